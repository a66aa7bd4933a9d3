#include "hal/linux/system/heap_watch.h"

#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <malloc.h>

namespace stof::test {
namespace {

using hal::linux::heap_counts;
using hal::linux::HeapCounts;
using hal::linux::MarkedHeap;
using hal::linux::watch_heap_of_this_thread;

// What is returned is looked at: compilers leave out blocks that nobody looks at.
void use(void* block) {
  void* volatile const seen = block;
  std::free(seen);
}

TEST(HeapWatch, CountsEveryKindOfCallOnce) {
  watch_heap_of_this_thread();
  ASSERT_TRUE(heap_counts().counted);
  EXPECT_EQ(heap_counts().calls, 0U);
  use(std::malloc(1));
  use(std::calloc(1, 1));
  use(std::realloc(nullptr, 8));
  use(std::aligned_alloc(64, 64));
  use(memalign(64, 64));
  use(reallocarray(nullptr, 2, 4));
  void* block = nullptr;
  const int error = posix_memalign(&block, 64, 64);
  use(block);
  EXPECT_EQ(error, 0);
  EXPECT_EQ(heap_counts().calls, 7U);
  EXPECT_EQ(heap_counts().marked, 0U);
}

TEST(HeapWatch, CountsMarkedCallsApart) {
  watch_heap_of_this_thread();
  {
    const MarkedHeap outer;
    use(std::malloc(1));
    {
      const MarkedHeap inner;
      use(std::malloc(1));
    }
    use(std::malloc(1));
  }
  use(std::malloc(1));
  EXPECT_EQ(heap_counts().marked, 3U);
  EXPECT_EQ(heap_counts().calls, 1U);
}

TEST(HeapWatch, CountsNoOtherThread) {
  watch_heap_of_this_thread();
  std::uint64_t before = 0;
  std::thread other([] {
    for (int i = 0; i < 100; ++i) {
      use(std::malloc(1));
    }
  });
  before = heap_counts().calls;
  other.join();
  EXPECT_EQ(heap_counts().calls, before);
}

#ifdef STOF_STATIC_PROGRAM
TEST(HeapWatch, CountsOperatorNewAndTheLibrariesOfAStaticProgram) {
  watch_heap_of_this_thread();
  delete new int volatile(1);
  const std::uint64_t after_new = heap_counts().calls;
  const std::string text(1000, 'x');
  const std::uint64_t after_string = heap_counts().calls;
  char* const copy = strdup(text.c_str());
  const std::uint64_t after_strdup = heap_counts().calls;
  use(copy);
  EXPECT_EQ(after_new, 1U);
  EXPECT_EQ(after_string, 2U);
  EXPECT_EQ(after_strdup, 3U);
}
#endif

}  // namespace
}  // namespace stof::test

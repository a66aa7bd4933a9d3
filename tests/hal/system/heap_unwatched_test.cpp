#include <cstdlib>

#include <gtest/gtest.h>

#include "hal/linux/system/heap_watch.h"

namespace stof::test {
namespace {

TEST(HeapWatch, WithoutTheLinkersHelpSaysThatNothingIsCounted) {
  hal::linux::watch_heap_of_this_thread();
  void* volatile const block = std::malloc(1);
  std::free(block);
  EXPECT_FALSE(hal::linux::heap_counts().counted);
  EXPECT_EQ(hal::linux::heap_counts().calls, 0U);
}

}  // namespace
}  // namespace stof::test

#include "posix/out_of_resources.h"

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <system_error>

#include <gtest/gtest.h>

#include "tests/support/address_sanitizer.h"

namespace stof::posix {
namespace {

[[noreturn]] void throw_what_a_thread_throws() {
  throw std::system_error(EAGAIN, std::generic_category());
}
// As a program without exceptions is for whatever throws in it.
void let_nothing_through(void (*what)()) noexcept { what(); }

TEST(OutOfResources, MemoryThatIsRefusedEndsInOneLine) {
  if (test::kAddressSanitizer) {
    GTEST_SKIP() << "AddressSanitizer's allocator ends in its own way";
  }
  EXPECT_EXIT(
      {
        end_in_one_line_when_refused("program");
        volatile std::size_t size = SIZE_MAX / 4;
        static_cast<void>(::operator new(size));
      },
      testing::ExitedWithCode(1), "^program: the system refuses memory: [^\n]*\n$");
}

TEST(OutOfResources, AThreadThatIsRefusedEndsInOneLine) {
  EXPECT_EXIT(
      {
        end_in_one_line_when_refused("program");
        let_nothing_through(throw_what_a_thread_throws);
      },
      testing::ExitedWithCode(1), "^program: the system refuses a thread: [^\n]*\n$");
}

TEST(OutOfResources, AnyOtherEndIsABugAndAborts) {
  EXPECT_EXIT(
      {
        end_in_one_line_when_refused("program");
        std::terminate();
      },
      testing::KilledBySignal(SIGABRT), "");
}

}  // namespace
}  // namespace stof::posix

#include "hal/linux/system/realtime.h"

#include <string>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/address_sanitizer.h"

namespace stof::test {
namespace {

using hal::linux::lock_memory;
using hal::linux::prefault_stack;
using hal::linux::RealtimeNote;
using hal::linux::set_fifo_priority;
using hal::linux::set_ordinary_priority;

// AddressSanitizer puts a mlockall() that does nothing in the system's place.
constexpr bool kLocks = !test::kAddressSanitizer;

// Runs `body` in a child process that may do nothing special; whether it returned true.
template <typename Body>
bool holds_without_rights(Body body) {
  const pid_t child = fork();
  if (child == 0) {
    const rlimit nothing{.rlim_cur = 0, .rlim_max = 0};
    const bool powerless = setrlimit(RLIMIT_RTPRIO, &nothing) == 0 &&
                           setrlimit(RLIMIT_MEMLOCK, &nothing) == 0 &&
                           (getuid() != 0 || setuid(65534) == 0);
    _exit(powerless && body() ? 0 : 1);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool is_a_note(const RealtimeNote& note, const char* right) {
  return note && note->find(right) != std::string::npos && note->find('\n') == std::string::npos;
}

TEST(Realtime, RefusalsAreNotesThatSayWhatToDo) {
  EXPECT_TRUE(holds_without_rights([] { return is_a_note(set_fifo_priority(50), "ulimit -r"); }));
  if (kLocks) {
    EXPECT_TRUE(holds_without_rights([] { return is_a_note(lock_memory(), "ulimit -l"); }));
  }
}

TEST(Realtime, OrdinaryPriorityNeedsNoRight) {
  EXPECT_TRUE(holds_without_rights([] { return !set_ordinary_priority(); }));
}

TEST(Realtime, PrivateMemoryLeavesNoCoreFile) {
  if (!kLocks) {
    GTEST_SKIP() << "a leak checker looks into the process";
  }
  EXPECT_TRUE(holds_without_rights([] {
    hal::linux::keep_memory_private();
    return prctl(PR_GET_DUMPABLE) == 0;
  }));
}

TEST(Realtime, PriorityOutsideOfTheRangeIsANote) {
  for (const int priority : {-1, 0, 100}) {
    EXPECT_TRUE(is_a_note(set_fifo_priority(priority), "give 1 to 99"));
  }
  EXPECT_EQ(sched_getscheduler(0) & 0xFF, SCHED_OTHER);
}

TEST(Realtime, GoesThereAndBackWhereItMay) {
  const RealtimeNote note = set_fifo_priority(1);
  if (note) {
    GTEST_SKIP() << *note;
  }
  EXPECT_EQ(sched_getscheduler(0) & 0xFF, SCHED_FIFO);
  EXPECT_FALSE(set_ordinary_priority());
  EXPECT_EQ(sched_getscheduler(0) & 0xFF, SCHED_OTHER);
}

TEST(Realtime, PrefaultsAnyStackWithinItsBound) {
  for (const std::size_t bytes :
       {std::size_t{0}, std::size_t{1}, std::size_t{256} << 10, std::size_t{1} << 40}) {
    prefault_stack(bytes);
  }
  SUCCEED();
}

}  // namespace
}  // namespace stof::test

#include "hal/linux/realtime.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace stof::test {
namespace {

using hal::posix::lock_memory;
using hal::posix::prefault_stack;
using hal::posix::raise_interrupt_threads;
using hal::posix::RealtimeNote;
using hal::posix::set_fifo_priority;
using hal::posix::set_ordinary_priority;

// AddressSanitizer puts a mlockall() that does nothing in the system's place.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kLocks = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool kLocks = false;
#else
constexpr bool kLocks = true;
#endif
#else
constexpr bool kLocks = true;
#endif

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

// A folder like /proc in which processes have chosen names.
class Processes {
 public:
  Processes() {
    std::string name = testing::TempDir() + "procXXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~Processes() { std::filesystem::remove_all(folder_); }
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  void add(const std::string& process, const char* name) const {
    std::filesystem::create_directory(folder_ / process);
    std::ofstream(folder_ / process / "comm") << name << '\n';
  }
  std::string path() const { return folder_.string(); }

 private:
  std::filesystem::path folder_;
};

TEST(Realtime, RaisesTheInterruptThreadsOfTheDeviceAlone) {
  const Processes processes;
  const std::string self = std::to_string(getpid());
  for (const char* const other :
       {"irq/7-stofx", "irq/7", "stof", "xirq/7-stof", "irq/7-mystof", "irq/7-"}) {
    processes.add(self, other);
    EXPECT_FALSE(raise_interrupt_threads("stof", 2, processes.path())) << other;
    EXPECT_EQ(sched_getscheduler(0) & 0xFF, SCHED_OTHER) << other;
  }
  processes.add("self", "irq/7-stof");
  processes.add("1x", "irq/7-stof");
  EXPECT_FALSE(raise_interrupt_threads("stof", 2, processes.path()));
  EXPECT_FALSE(raise_interrupt_threads("stof", 2, processes.path() + "/none"));
}

TEST(Realtime, InterruptThreadsAreRaisedAndNeverLowered) {
  if (const RealtimeNote note = set_fifo_priority(1)) {
    GTEST_SKIP() << *note;
  }
  const Processes processes;
  const std::string self = std::to_string(getpid());
  for (const auto& [name, device] :
       {std::pair{"irq/29-stof", "stof"}, std::pair{"irq/105-longnam", "longname"}}) {
    EXPECT_FALSE(set_fifo_priority(1));
    processes.add(self, name);
    for (const int priority : {2, 1}) {
      EXPECT_FALSE(raise_interrupt_threads(device, priority, processes.path()));
      sched_param parameters{};
      EXPECT_EQ(sched_getparam(0, &parameters), 0);
      EXPECT_EQ(parameters.sched_priority, 2) << name;
    }
  }
  EXPECT_FALSE(set_ordinary_priority());
}

TEST(Realtime, InterruptThreadsThatAreRefusedAreANote) {
  const Processes processes;
  processes.add("1", "irq/29-stof");
  std::filesystem::permissions(processes.path(), std::filesystem::perms::all);
  EXPECT_TRUE(holds_without_rights([&] {
    return is_a_note(raise_interrupt_threads("stof", 81, processes.path()), "CAP_SYS_NICE");
  }));
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

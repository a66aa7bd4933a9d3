#include "hal/linux/system/realtime.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <alloca.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

namespace stof::hal::linux {
namespace {

constexpr std::size_t kMostStack = std::size_t{1} << 20;

std::string line(const std::string& what, int error, const char* advice) {
  return what + ": " + std::strerror(error) + "; " + advice;
}

int set_policy(int policy, int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return sched_setscheduler(0, policy, &parameters) == 0 ? 0 : errno;
}

}  // namespace

RealtimeNote lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
    return std::nullopt;
  }
  return line("memory is not locked", errno, "allow it: CAP_IPC_LOCK, or 'ulimit -l unlimited'");
}

// A leak checker looks into the process as a debugger does.
#if defined(__SANITIZE_ADDRESS__)
#define STOF_LEAK_CHECKER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define STOF_LEAK_CHECKER 1
#endif
#endif
#if defined(STOF_LEAK_CHECKER)
void keep_memory_private() noexcept {}
#else
void keep_memory_private() noexcept { static_cast<void>(prctl(PR_SET_DUMPABLE, 0)); }
#endif

[[gnu::noinline]] void prefault_stack(std::size_t bytes) noexcept {
  const std::size_t size = std::min(bytes, kMostStack);
  if (size == 0) {
    return;
  }
  const std::size_t page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  // The only array whose size a caller chooses, and it is bounded.
  volatile unsigned char* const stack = static_cast<unsigned char*>(alloca(size));
  for (std::size_t at = 0; at < size; at += page) {
    stack[size - 1 - at] = 0;  // from the top down, as the kernel grows a stack
  }
}

RealtimeNote set_fifo_priority(int priority) {
  const std::string what = "no real-time priority " + std::to_string(priority);
  if (priority < sched_get_priority_min(SCHED_FIFO) ||
      priority > sched_get_priority_max(SCHED_FIFO)) {
    return line(what, EINVAL, "give 1 to 99");
  }
  const int error = set_policy(SCHED_FIFO, priority);
  if (error == 0) {
    return std::nullopt;
  }
  return line(what, error,
              "allow it: CAP_SYS_NICE, or 'ulimit -r 99'; with cgroup limits: rt_runtime");
}

RealtimeNote set_ordinary_priority() {
  const int error = set_policy(SCHED_OTHER, 0);
  if (error == 0) {
    return std::nullopt;
  }
  return line("real-time priority stays", error, "restart the program");
}

}  // namespace stof::hal::linux

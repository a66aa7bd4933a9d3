#include "hal/linux/realtime.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include <alloca.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

namespace stof::hal::posix {
namespace {

constexpr std::size_t kMostStack = std::size_t{1} << 20;

std::string line(const std::string& what, int error, const std::string& advice) {
  return what + ": " + std::strerror(error) + "; " + advice;
}

// Of "/proc/27": 27; 0: not a process.
pid_t process_of(const std::filesystem::path& folder) {
  const std::string name = folder.filename().string();
  pid_t id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  return error == std::errc{} && end == name.data() + name.size() ? id : 0;
}

// Whether that process is a thread of the kernel for interrupts of `device`. Names are cut.
bool serves(const std::filesystem::path& folder, const std::string& device) {
  constexpr std::size_t kMostName = 15;
  constexpr std::string_view kPrefix = "irq/";
  std::ifstream file(folder / "comm");
  std::string name;
  std::getline(file, name);
  const std::size_t dash = name.find('-');
  if (!name.starts_with(kPrefix) || dash == std::string::npos) {
    return false;
  }
  return name == (name.substr(0, dash + 1) + device).substr(0, kMostName);
}

// 0, or errno.
int make_urgent(pid_t thread, int priority) noexcept {
  sched_param parameters{};
  if (sched_getparam(thread, &parameters) == 0 && parameters.sched_priority >= priority) {
    return 0;
  }
  parameters.sched_priority = priority;
  return sched_setscheduler(thread, SCHED_FIFO, &parameters) == 0 ? 0 : errno;
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

RealtimeNote raise_interrupt_threads(const std::string& device, int priority,
                                     const std::string& proc) {
  int refused = 0;
  std::error_code error;
  const std::filesystem::directory_iterator end;
  for (std::filesystem::directory_iterator it(proc, error); !error && it != end;
       it.increment(error)) {
    const pid_t thread = process_of(it->path());
    if (thread > 0 && serves(it->path(), device)) {
      const int code = make_urgent(thread, priority);
      refused = refused == 0 ? code : refused;
    }
  }
  if (refused == 0) {
    return std::nullopt;
  }
  return line("interrupts of " + device + " stay less urgent than this program", refused,
              "allow it: CAP_SYS_NICE, or raise the threads irq/*-" + device + " with chrt");
}

}  // namespace stof::hal::posix

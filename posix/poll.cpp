#include "posix/poll.h"

#include <algorithm>
#include <cerrno>
#include <ctime>

namespace stof::posix {

std::expected<int, int> wait_for(std::span<pollfd> entries,
                                 std::chrono::nanoseconds timeout) noexcept {
  timeout = std::max(timeout, std::chrono::nanoseconds::zero());
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(timeout);
  timespec limit{};
  limit.tv_sec = static_cast<time_t>(whole.count());
  limit.tv_nsec = static_cast<long>((timeout - whole).count());  // NOLINT: timespec's
  const int ready = ppoll(entries.data(), entries.size(), &limit, nullptr);
  if (ready < 0 && errno != EINTR) {
    return std::unexpected(errno);
  }
  return std::max(ready, 0);
}

}  // namespace stof::posix

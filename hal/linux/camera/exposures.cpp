#include "hal/linux/camera/exposures.h"

#include <algorithm>

namespace stof::hal::linux {

std::optional<Time> EdgeLog::at_or_before(Time time) const noexcept {
  const std::size_t count = count_.load(std::memory_order_acquire);
  const std::size_t known = std::min(count, kDepth);
  for (std::size_t back = 1; back <= known; ++back) {
    const Time noted = edge(count - back);
    if (noted <= time) {
      return noted;
    }
  }
  return std::nullopt;
}

std::optional<Time> EdgeLog::nearest(Time time) const noexcept {
  const std::optional<Time> before = at_or_before(time);
  std::optional<Time> after;
  const std::size_t count = count_.load(std::memory_order_acquire);
  const std::size_t known = std::min(count, kDepth);
  for (std::size_t back = 1; back <= known; ++back) {
    const Time noted = edge(count - back);
    if (noted <= time) {
      break;
    }
    after = noted;
  }
  if (!before || !after) {
    return before ? before : after;
  }
  return time - *before <= *after - time ? before : after;
}

}  // namespace stof::hal::linux

#include "firmware/serial/line/line_budget.h"

#include <algorithm>

namespace stof::firmware {

hal::Duration LineBudget::backlog(hal::Time now) const noexcept {
  return std::max(free_at_ - now, hal::Duration::zero());
}

void LineBudget::spend(std::size_t bytes, hal::Time now) noexcept {
  constexpr std::uint64_t kBitsPerByte = 10;
  constexpr std::uint64_t kNsPerSecond = 1'000'000'000;
  const std::uint64_t ns = (bytes * kBitsPerByte * kNsPerSecond + baud_ - 1) / baud_;
  free_at_ = std::max(free_at_, now) + hal::Duration(static_cast<hal::Duration::rep>(ns));
}

}  // namespace stof::firmware

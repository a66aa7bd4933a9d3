#include "firmware/loop/device_lending.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace stof::firmware {

void DeviceLending::Pace::note_return(hal::Time now) noexcept {
  if (std::exchange(tried_, false)) {
    at_ = now + backoff_;
    backoff_ = std::min(2 * backoff_, longest_);
  }
}

bool DeviceLending::after_round(board::Device device, Need need, bool borrowed,
                                hal::Time now) noexcept {
  if (is_lent(device)) {
    return false;
  }
  Retry& retry = retries_[static_cast<std::size_t>(device)];
  retry.lost.note_return(now);
  retry.repeats.note_return(now);
  if (need != Need::kLost) {
    retry.lost.start_over();
  }
  if (need == Need::kNone && retry.repeats.long_past(now)) {
    retry.repeats.start_over();
  }
  Pace& pace = need == Need::kLost ? retry.lost : retry.repeats;
  if (need == Need::kNone || borrowed || !pace.due(now)) {
    return false;
  }
  pace.lend();
  lent_.fetch_or(bit(device), std::memory_order_release);
  lent_.notify_all();
  // What is waited on is what was looked at: a device that comes back in between is seen.
  unsigned seen = waits_ ? lent_.load(std::memory_order_acquire) : 0;
  while ((seen & bit(device)) != 0) {
    lent_.wait(seen, std::memory_order_acquire);
    seen = lent_.load(std::memory_order_acquire);
  }
  return true;
}

std::optional<board::Device> DeviceLending::wait_for_lent() noexcept {
  lent_.wait(0, std::memory_order_acquire);
  const unsigned lent = lent_.load(std::memory_order_acquire);
  if ((lent & kEnd) != 0) {
    return std::nullopt;
  }
  return static_cast<board::Device>(std::countr_zero(lent));
}

void DeviceLending::give_back(board::Device device) noexcept {
  lent_.fetch_and(~bit(device), std::memory_order_release);
  lent_.notify_all();
}

void DeviceLending::end() noexcept {
  lent_.fetch_or(kEnd, std::memory_order_release);
  lent_.notify_all();
}

}  // namespace stof::firmware

#include "firmware/loop/device_lending.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace stof::firmware {

void DeviceLending::after_round(board::Device device, bool lost, bool borrowed,
                                hal::Time now) noexcept {
  if (is_lent(device)) {
    return;
  }
  Retry& retry = retries_[static_cast<std::size_t>(device)];
  if (std::exchange(retry.tried, false)) {
    retry.at = now + retry.backoff;
    retry.backoff = std::min(2 * retry.backoff, kLongestBackoff);
  }
  if (!lost) {
    retry.backoff = kFirstBackoff;
    return;
  }
  if (borrowed || now < retry.at) {
    return;
  }
  retry.tried = true;
  lent_.fetch_or(bit(device), std::memory_order_release);
  lent_.notify_all();
  // What is waited on is what was looked at: a device that comes back in between is seen.
  unsigned seen = waits_ ? lent_.load(std::memory_order_acquire) : 0;
  while ((seen & bit(device)) != 0) {
    lent_.wait(seen, std::memory_order_acquire);
    seen = lent_.load(std::memory_order_acquire);
  }
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

#include "firmware/serial/line/serial_link.h"

#include <algorithm>
#include <chrono>

namespace stof::firmware {
namespace {

constexpr hal::Duration kFirstBackoff = std::chrono::milliseconds(50);
constexpr hal::Duration kLongestBackoff = std::chrono::seconds(1);

}  // namespace

hal::Duration SerialLink::turn(std::uint32_t baud) noexcept {
  return std::clamp<hal::Duration>(line_time(LineSpeed::kDriverBytes / 2, baud),
                                   std::chrono::milliseconds(1), LineSpeed::kLongestTurn);
}

void SerialLink::set(settings::SerialMode mode, std::uint32_t baud) noexcept {
  mode_ = mode;
  speed_.want(baud);
}

void SerialLink::tick(hal::Time now) noexcept {
  if (lost()) {
    reopen_when_due(now);
  }
  if (lost() || mode_ == settings::SerialMode::kOff) {
    writer_.discard();
  } else if (exchange(now) == Status::kDeviceLost) {
    lose(now);
  }
}

Status SerialLink::exchange(hal::Time now) noexcept {
  if (!writer_.answering()) {
    const Result<std::span<const std::byte>> answer = reader_.read(port_, mode_, now);
    if (!answer) {
      return answer.error();
    }
    writer_.answer(*answer);
  }
  const Result<bool> changed = speed_.tick(port_, writer_.idle(), now);
  if (!changed) {
    return changed.error();
  }
  if (*changed) {
    writer_.begin_anew();
  }
  return writer_.write(port_, speed_.changing(), now);
}

void SerialLink::reopen_when_due(hal::Time now) noexcept {
  if (now < retry_at_) {
    return;
  }
  if (port_.reopen() != Status::kOk) {
    retry_backoff_ = std::min(2 * retry_backoff_, kLongestBackoff);
    retry_at_ = now + retry_backoff_;
    return;
  }
  lost_.store(false, std::memory_order_relaxed);
  retry_backoff_ = {};
}

void SerialLink::lose(hal::Time now) noexcept {
  lost_.store(true, std::memory_order_relaxed);
  retry_backoff_ = kFirstBackoff;
  retry_at_ = now + retry_backoff_;
  reader_.reset();
  speed_.restart();
  writer_.begin_anew();
  writer_.discard();
}

SerialLink::Counters SerialLink::counters() const noexcept {
  return {.sent = writer_.sent(), .lost = writer_.discarded(), .refused = reader_.refused()};
}

}  // namespace stof::firmware

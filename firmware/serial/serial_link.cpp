#include "firmware/serial/serial_link.h"

#include <algorithm>
#include <optional>

namespace stof::firmware {
namespace {

using settings::SerialMode;

constexpr hal::Duration kFirstBackoff = std::chrono::milliseconds(50);
constexpr hal::Duration kLongestBackoff = std::chrono::seconds(1);
constexpr hal::Duration kLongestTurn = std::chrono::milliseconds(20);
constexpr hal::Duration kQuiet = std::chrono::milliseconds(100);
constexpr std::uint32_t kDriverBytes = 4096;   // a page: what serial drivers queue
constexpr std::size_t kBytesPerTick = 65'536;  // in each direction: less than a millisecond's work

constexpr hal::Duration time_of(std::uint64_t bytes, std::uint32_t baud) noexcept {
  constexpr std::uint64_t kTenBitsNs = 10'000'000'000;
  return hal::Duration(static_cast<hal::Duration::rep>(bytes * kTenBitsNs / std::max(baud, 1U)));
}

bool is_packet(std::span<const std::byte> record) noexcept {
  return !record.empty() && record[0] == std::byte{'S'};  // MAVLink begins with another byte
}

}  // namespace

hal::Duration SerialLink::turn(std::uint32_t baud) noexcept {
  return std::clamp<hal::Duration>(time_of(kDriverBytes / 2, baud), std::chrono::milliseconds(1),
                                   kLongestTurn);
}

void SerialLink::set(SerialMode mode, std::uint32_t baud) noexcept {
  mode_ = mode;
  wanted_baud_ = baud;
  if (baud_ == 0) {
    baud_ = baud;
  }
}

void SerialLink::tick(hal::Time now) noexcept {
  if (lost()) {
    reopen_when_due(now);
  }
  if (lost() || mode_ == SerialMode::kOff) {
    discard();
    return;
  }
  read(now);
  if (lost()) {
    return;
  }
  if (wanted_baud_ != baud_) {
    change_baud(now);
  } else {
    changing_ = false;
  }
  if (!lost()) {
    write(now);
  }
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
  packets_.reset();
  messages_.reset();
  unread_ = {};
  quiet_ = true;
  changing_ = false;
  discard();
}

void SerialLink::discard() noexcept {
  std::uint64_t count = (staged_size_ > 0 ? 1U : 0U) + (answer_.empty() ? 0U : 1U);
  staged_at_ = 0;
  staged_size_ = 0;
  answer_ = {};
  count += discard_ring();
  add(dropped_, count);
}

std::uint64_t SerialLink::discard_ring() noexcept {
  std::uint64_t count = 0;
  while (ring_.take(record_) > 0) {
    ++count;
  }
  return count;
}

void SerialLink::change_baud(hal::Time now) noexcept {
  if (!changing_) {
    changing_ = true;
    change_at_ = now + kLongestTurn + time_of(kDriverBytes + 2 * staged_.size(), baud_);
  }
  if (now < change_at_ || staged_size_ > 0 || !answer_.empty()) {
    return;
  }
  changing_ = false;
  const Status status = port_.set_baud(wanted_baud_);
  if (status == Status::kDeviceLost) {
    lose(now);  // and again once it is back
    return;
  }
  baud_refused_.store(status != Status::kOk, std::memory_order_relaxed);
  baud_ = status == Status::kOk ? wanted_baud_ : baud_;
  wanted_baud_ = baud_;
  quiet_ = true;
}

void SerialLink::read(hal::Time now) noexcept {
  std::size_t total = 0;
  // An answer has to leave before the next request is looked at.
  while (answer_.empty() && total < kBytesPerTick) {
    if (unread_.empty()) {
      const Result<std::size_t> count = port_.read(input_);
      if (!count) {
        lose(now);
        return;
      }
      if (*count == 0) {
        return;
      }
      unread_ = std::span<const std::byte>(input_).first(*count);
      total += *count;
    }
    take(now);
  }
}

void SerialLink::take(hal::Time now) noexcept {
  if (mode_ == SerialMode::kMavlink) {
    while (const std::optional<mavlink::Message> message = messages_.take(unread_)) {
      mavlink::heard(*message, now, autopilot_);
    }
  } else if (const std::optional<std::span<const std::byte>> frame = packets_.take(unread_)) {
    answer_ = requests_.take(*frame);
  }
  refused_.store(requests_.counters().refused + packets_.counters().broken +
                     packets_.counters().too_long + messages_.counters().damaged,
                 std::memory_order_relaxed);
}

void SerialLink::write(hal::Time now) noexcept {
  for (std::size_t total = 0; total < kBytesPerTick;) {
    if (staged_size_ == 0 && !stage(now)) {
      return;
    }
    const std::span<const std::byte> rest =
        std::span<const std::byte>(staged_).subspan(staged_at_, staged_size_ - staged_at_);
    const Result<std::size_t> count = port_.write(rest);
    if (!count) {
      lose(now);
      return;
    }
    staged_at_ += *count;
    total += *count;
    last_write_ = *count > 0 ? now : last_write_;
    if (staged_at_ < staged_size_) {
      return;
    }
    staged_at_ = 0;
    staged_size_ = 0;
    add(sent_, 1);
  }
}

bool SerialLink::stage(hal::Time now) noexcept {
  if (!answer_.empty()) {
    stage_packet(answer_, now);
    answer_ = {};
    return true;
  }
  if (changing_) {
    add(dropped_, discard_ring());
    return false;
  }
  const std::span<const std::byte> record =
      std::span<const std::byte>(record_).first(ring_.take(record_));
  if (is_packet(record)) {
    stage_packet(record, now);
  } else {
    std::ranges::copy(record, staged_.begin());
    staged_size_ = record.size();
  }
  return staged_size_ > 0;
}

void SerialLink::stage_packet(std::span<const std::byte> packet, hal::Time now) noexcept {
  const std::span<std::byte> out(staged_);
  const std::size_t begin = quiet_ || now - last_write_ >= kQuiet ? 1 : 0;
  quiet_ = false;
  out[0] = std::byte{0};
  const std::size_t end = begin + hal::cobs_encode(packet, out.subspan(begin));
  out[end] = std::byte{0};
  staged_size_ = end + 1;
}

void SerialLink::add(std::atomic<std::uint64_t>& counter, std::uint64_t count) noexcept {
  // One thread writes; the others only have to see whole numbers.
  counter.store(counter.load(std::memory_order_relaxed) + count, std::memory_order_relaxed);
}

SerialLink::Counters SerialLink::counters() const noexcept {
  return {.sent = sent_.load(std::memory_order_relaxed),
          .lost = dropped_.load(std::memory_order_relaxed),
          .refused = refused_.load(std::memory_order_relaxed)};
}

}  // namespace stof::firmware

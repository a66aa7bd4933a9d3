#include "firmware/serial/line/line_writer.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace stof::firmware {
namespace {

constexpr std::size_t kBytesPerTick = 65'536;  // less than a millisecond's work
constexpr hal::Duration kSilence = std::chrono::milliseconds(100);

bool is_packet(std::span<const std::byte> record) noexcept {
  return !record.empty() && record[0] == std::byte{'S'};  // MAVLink begins with another byte
}

// One thread writes; the others only have to see whole numbers.
void add(std::atomic<std::uint64_t>& counter, std::uint64_t count) noexcept {
  counter.store(counter.load(std::memory_order_relaxed) + count, std::memory_order_relaxed);
}

}  // namespace

Status LineWriter::write(hal::SerialPort& port, bool answers_only, hal::Time now) noexcept {
  for (std::size_t total = 0; total < kBytesPerTick;) {
    if (staged_size_ == 0 && !stage(answers_only, now)) {
      return Status::kOk;
    }
    const std::span<const std::byte> rest =
        std::span<const std::byte>(staged_).subspan(staged_at_, staged_size_ - staged_at_);
    const Result<std::size_t> count = port.write(rest);
    if (!count) {
      return Status::kDeviceLost;
    }
    staged_at_ += *count;
    total += *count;
    last_write_ = *count > 0 ? now : last_write_;
    if (staged_at_ < staged_size_) {
      return Status::kOk;
    }
    staged_at_ = 0;
    staged_size_ = 0;
    add(sent_, 1);
  }
  return Status::kOk;
}

bool LineWriter::stage(bool answers_only, hal::Time now) noexcept {
  if (answering()) {
    stage_packet(std::exchange(answer_, {}), now);
    return true;
  }
  if (answers_only) {
    add(discarded_, discard_ring());
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

void LineWriter::stage_packet(std::span<const std::byte> packet, hal::Time now) noexcept {
  const std::span<std::byte> out(staged_);
  const std::size_t begin = silent_ || now - last_write_ >= kSilence ? 1 : 0;
  silent_ = false;
  out[0] = std::byte{0};
  const std::size_t end = begin + hal::cobs_encode(packet, out.subspan(begin));
  out[end] = std::byte{0};
  staged_size_ = end + 1;
}

void LineWriter::discard() noexcept {
  const std::uint64_t waiting = (staged_size_ > 0 ? 1U : 0U) + (answering() ? 1U : 0U);
  staged_at_ = 0;
  staged_size_ = 0;
  answer_ = {};
  add(discarded_, waiting + discard_ring());
}

std::uint64_t LineWriter::discard_ring() noexcept {
  std::uint64_t count = 0;
  while (ring_.take(record_) > 0) {
    ++count;
  }
  return count;
}

}  // namespace stof::firmware

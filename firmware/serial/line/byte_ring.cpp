#include "firmware/serial/line/byte_ring.h"

#include <algorithm>
#include <array>
#include <bit>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"

namespace stof::firmware {

ByteRing::ByteRing(std::span<std::byte> memory) noexcept : memory_(memory) {
  STOF_CHECK(std::has_single_bit(memory.size()));
}

std::size_t ByteRing::room() const noexcept {
  return memory_.size() - (writing_ - read_.load(std::memory_order_acquire));
}

void ByteRing::put(std::span<const std::byte> record) noexcept {
  STOF_CHECK(!record.empty() && record.size() <= kMaxRecord && cost(record.size()) <= room());
  std::array<std::byte, 2> length{};
  wire::put_u16(length, static_cast<std::uint16_t>(record.size()));
  copy_in(writing_, length);
  copy_in(writing_ + length.size(), record);
  writing_ += cost(record.size());
}

std::size_t ByteRing::waiting() const noexcept {
  return written_.load(std::memory_order_acquire) - read_.load(std::memory_order_relaxed);
}

std::size_t ByteRing::next() const noexcept {
  if (waiting() == 0) {
    return 0;
  }
  std::array<std::byte, 2> length{};
  copy_out(read_.load(std::memory_order_relaxed), length);
  return wire::get_u16(length);
}

std::size_t ByteRing::take(std::span<std::byte> out) noexcept {
  const std::size_t size = next();
  if (size == 0) {
    return 0;
  }
  const std::size_t at = read_.load(std::memory_order_relaxed);
  const std::size_t count = std::min(size, out.size());
  copy_out(at + 2, out.first(count));
  read_.store(at + cost(size), std::memory_order_release);
  return count;
}

void ByteRing::copy_in(std::size_t at, std::span<const std::byte> bytes) noexcept {
  const std::size_t first = at & (memory_.size() - 1);
  const std::size_t upper = std::min(bytes.size(), memory_.size() - first);
  std::ranges::copy(bytes.first(upper), memory_.subspan(first).begin());
  std::ranges::copy(bytes.subspan(upper), memory_.begin());
}

void ByteRing::copy_out(std::size_t at, std::span<std::byte> bytes) const noexcept {
  const std::size_t first = at & (memory_.size() - 1);
  const std::size_t upper = std::min(bytes.size(), memory_.size() - first);
  std::ranges::copy(memory_.subspan(first, upper), bytes.begin());
  std::ranges::copy(memory_.first(bytes.size() - upper), bytes.subspan(upper).begin());
}

}  // namespace stof::firmware

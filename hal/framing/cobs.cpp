#include "hal/framing/cobs.h"

#include "dsp/base/check.h"

namespace stof::hal {
namespace {

constexpr unsigned kLongBlock = 255;  // 254 bytes, and no zero behind them

}  // namespace

std::size_t cobs_encode(std::span<const std::byte> frame, std::span<std::byte> out) noexcept {
  STOF_CHECK(out.size() >= cobs_bound(frame.size()));
  std::size_t code_at = 0;
  std::size_t size = 1;
  unsigned code = 1;
  bool closed = false;  // the last block was a long one: nothing is open
  for (const std::byte value : frame) {
    if (closed) {
      code_at = size++;
      closed = false;
    }
    if (value != std::byte{0}) {
      out[size++] = value;
      ++code;
    }
    if (value == std::byte{0} || code == kLongBlock) {
      out[code_at] = static_cast<std::byte>(code);
      closed = code == kLongBlock;
      code = 1;
      if (!closed) {
        code_at = size++;
      }
    }
  }
  if (!closed) {
    out[code_at] = static_cast<std::byte>(code);
  }
  return size;
}

std::optional<std::span<const std::byte>> CobsReader::take(
    std::span<const std::byte>& bytes) noexcept {
  while (!bytes.empty()) {
    const std::byte value = bytes.front();
    bytes = bytes.subspan(1);
    if (value == std::byte{0}) {
      if (const std::optional<std::span<const std::byte>> frame = end()) {
        return frame;
      }
    } else if (left_ > 0) {
      --left_;
      append(value);
    } else {
      if (zero_pending_) {
        append(std::byte{0});
      }
      const unsigned code = std::to_integer<unsigned>(value);
      begun_ = true;
      left_ = code - 1;
      zero_pending_ = code != kLongBlock;
    }
  }
  return std::nullopt;
}

void CobsReader::reset() noexcept {
  size_ = 0;
  left_ = 0;
  begun_ = false;
  zero_pending_ = false;
  too_long_ = false;
}

std::optional<std::span<const std::byte>> CobsReader::end() noexcept {
  const bool begun = begun_;
  const bool whole = left_ == 0;
  const bool too_long = too_long_;
  const std::span<const std::byte> frame = std::span<const std::byte>(frame_).first(size_);
  reset();
  if (!begun) {
    ++counters_.empty;
  } else if (too_long) {
    ++counters_.too_long;
  } else if (!whole) {
    ++counters_.broken;
  } else {
    ++counters_.frames;
    return frame;
  }
  return std::nullopt;
}

void CobsReader::append(std::byte value) noexcept {
  if (size_ == kMaxFrame) {
    too_long_ = true;
    return;
  }
  frame_[size_++] = value;
}

}  // namespace stof::hal

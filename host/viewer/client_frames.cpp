#include "host/viewer/client_frames.h"

#include <algorithm>

namespace stof::viewer {
namespace {

constexpr std::uint8_t kMasked = 0x80;  // of the second byte; the others are the size
constexpr std::uint8_t kTwoBytes = 126;
constexpr std::uint8_t kEightBytes = 127;
constexpr std::size_t kMaskBytes = 4;

}  // namespace

std::size_t ClientFrames::head_size() const noexcept {
  if (come_ < 2) {
    return 2;
  }
  const auto size = static_cast<std::uint8_t>(head_[1] & ~kMasked);
  std::size_t more = 0;
  if (size >= kTwoBytes) {
    more = size == kEightBytes ? 8 : 2;
  }
  return 2 + more + kMaskBytes;
}

std::uint64_t ClientFrames::payload_size() const noexcept {
  const std::size_t more = head_size() - 2 - kMaskBytes;
  if (more == 0) {
    return static_cast<std::uint8_t>(head_[1] & ~kMasked);
  }
  std::uint64_t size = 0;
  for (std::size_t i = 0; i < more; ++i) {
    size = size << 8 | head_[2 + i];
  }
  return size;
}

bool ClientFrames::take(std::span<const std::uint8_t> part, std::vector<std::uint8_t>& to) {
  while (!refused_ && !part.empty()) {
    if (payload_ > 0) {
      const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(payload_, part.size()));
      to.insert(to.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(size));
      payload_ -= size;
      part = part.subspan(size);
      continue;
    }
    head_[come_++] = part.front();
    part = part.subspan(1);
    refused_ = come_ == 2 && (head_[1] & kMasked) == 0;
    if (!refused_ && come_ == head_size()) {
      to.insert(to.end(), head_.begin(), head_.begin() + static_cast<std::ptrdiff_t>(come_));
      payload_ = payload_size();
      come_ = 0;
    }
  }
  return !refused_;
}

}  // namespace stof::viewer

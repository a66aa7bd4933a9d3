#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "host/recording/mcap/bytes.h"

namespace stof::mcap {

// CRC-32 of IEEE 802.3 (reflected, 0xEDB88320), as in zlib and PNG. Eight bytes a step.
class Crc32 {
 public:
  void add(Bytes bytes) noexcept;
  std::uint32_t value() const noexcept { return ~state_; }

 private:
  std::uint32_t state_ = 0xFFFFFFFF;
};

inline std::uint32_t crc32(Bytes bytes) noexcept {
  Crc32 crc;
  crc.add(bytes);
  return crc.value();
}

}  // namespace stof::mcap

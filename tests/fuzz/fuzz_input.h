#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/packet.h"

// What a fuzz target has: run(). The input of a target that takes datagrams: records of flags,
// length and bytes. A mutated packet would never get past its CRC; kSeal makes it whole again
// before it is pushed.
namespace stof::fuzz {

// One input, any bytes. Aborts where a promise of the code under test does not hold.
void run(std::span<const std::byte> input);

inline constexpr unsigned kSeal = 1;    // magic, version, lengths and CRC are set right
inline constexpr unsigned kCookie = 2;  // the newest cookie of the answers is written into it
inline constexpr std::size_t kRecordHeader = 3;
inline constexpr std::size_t kMostRecords = 64;

struct Record {
  unsigned flags = 0;
  std::span<const std::byte> bytes;

  unsigned peer() const noexcept { return flags >> 2 & 3; }  // 0 .. 3
  unsigned seconds() const noexcept { return flags >> 4; }   // 0 .. 15, later than the one before
};

// A promise of the code under test that does not hold is a finding.
inline void require(bool holds) noexcept {
  if (!holds) {
    std::abort();
  }
}

template <typename Take>
void for_each_record(std::span<const std::byte> input, Take&& take) {
  for (std::size_t i = 0; i < kMostRecords && input.size() >= kRecordHeader; ++i) {
    const auto flags = wire::get_u8(input.first<1>());
    const std::size_t length = wire::get_u16(input.subspan(1).first<2>());
    input = input.subspan(kRecordHeader);
    const std::size_t bytes = std::min(length, input.size());
    take(Record{.flags = flags, .bytes = input.first(bytes)});
    input = input.subspan(bytes);
  }
}

// The record's bytes as a packet whose header, lengths and CRC are right; `space` holds it. Cut off
// at the length of a datagram; as they are where they are too short for a header.
inline std::span<const std::byte> sealed(std::span<const std::byte> bytes,
                                         wire::DatagramBuffer& space) noexcept {
  constexpr std::size_t kLeast = wire::kHeaderBytes + wire::kCrcBytes;
  const std::size_t size = std::min(bytes.size(), space.size());
  std::ranges::copy(bytes.first(size), space.begin());
  const std::span<std::byte> packet = std::span(space).first(size);
  if (size < kLeast) {
    return packet;
  }
  wire::put_u32(packet.first<4>(), 0x464f5453);
  wire::put_u8(packet.subspan(4).first<1>(), wire::kWireVersion);
  wire::put_u8(packet.subspan(6).first<1>(), wire::kHeaderBytes);
  wire::put_u16(packet.subspan(50).first<2>(), static_cast<std::uint16_t>(size - kLeast));
  wire::put_u32(packet.last<4>(), wire::crc32c(packet.first(size - wire::kCrcBytes)));
  return packet;
}

// Bytes that are read one by one, so that a sanitizer sees where they lie.
inline unsigned touch(std::span<const std::byte> bytes) noexcept {
  volatile unsigned sum = 0;
  for (const std::byte byte : bytes) {
    sum = sum + std::to_integer<unsigned>(byte);
  }
  return sum;
}

}  // namespace stof::fuzz

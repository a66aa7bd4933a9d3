#pragma once

#include <cstddef>
#include <cstdint>

// What readers of any bytes allow a file, so that their memory and time are bounded by its size.
namespace stof::mcap {

struct Limits {
  std::uint64_t record_bytes = std::uint64_t{256} << 20;  // of one record, and of the summary
  std::uint64_t chunk_bytes = std::uint64_t{256} << 20;   // of one chunk's content
  std::size_t channels = 4096;                            // and schemas
};

// A chunk that unpacks to more than this may be so many times as large as it is packed. Ours have
// 4 MiB.
inline constexpr std::uint64_t kAnyRatioBytes = std::uint64_t{16} << 20;
inline constexpr std::uint64_t kMostRatio = 1024;

// All chunks up to a place of the file may unpack to so much: what reading takes is bounded by the
// file's size. Frames of one value with their indexes reach 1400 times.
constexpr std::uint64_t most_unpacked(std::uint64_t file_bytes) noexcept {
  constexpr std::uint64_t kAny = std::uint64_t{64} << 20;
  constexpr std::uint64_t kRatio = 4096;
  return kAny + kRatio * file_bytes;
}

// Messages in a chunk of so many packed bytes: each has a time of its own, which takes a byte.
constexpr std::uint64_t most_messages(std::uint64_t packed_bytes) noexcept {
  constexpr std::uint64_t kAny = 256;
  constexpr std::uint64_t kEachByte = 4;
  return kAny + kEachByte * packed_bytes;
}

}  // namespace stof::mcap

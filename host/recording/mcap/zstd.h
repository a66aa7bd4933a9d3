#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "host/recording/mcap/bytes.h"

// Chunks through libzstd.
namespace stof::mcap {

class ZstdCompressor {
 public:
  // Throws std::bad_alloc.
  explicit ZstdCompressor(int level);
  // Into `out`, whose memory is kept. Throws std::bad_alloc.
  void compress(Bytes bytes, Buffer& out);

 private:
  struct Close {
    void operator()(void* context) const noexcept;
  };
  std::unique_ptr<void, Close> context_;
};

// The most that `compressed` bytes of zstd can stand for: a block of 4 bytes is 128 KiB of one
// value.
constexpr std::uint64_t most_zstd_bytes(std::uint64_t compressed) noexcept {
  constexpr std::uint64_t kZstdRatio = 32768;
  return compressed * kZstdRatio;
}

// Whether `bytes` are zstd frames of exactly out.size() bytes, which are in `out` then. Any bytes.
bool decompress_zstd(Bytes bytes, std::span<std::byte> out) noexcept;

}  // namespace stof::mcap

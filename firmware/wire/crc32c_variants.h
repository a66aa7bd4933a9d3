#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

// What crc32c() chooses between; equal to each other, for it and for tests alone.
namespace stof::wire {

namespace table {
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) noexcept;
}  // namespace table

// The processor's own instructions: SSE4.2 on x86-64, the CRC32 extension on ARM64. Only where
// available() says so; it is asked once, at start.
namespace hardware {
bool available() noexcept;
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) noexcept;
}  // namespace hardware

}  // namespace stof::wire

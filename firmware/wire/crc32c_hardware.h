#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

// crc32c() by the processor's own instructions: SSE4.2 on x86-64, the CRC32 extension on ARM64.
// Only where available() says so; it is asked once, at start.
namespace stof::wire::hardware {

bool available() noexcept;
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) noexcept;

}  // namespace stof::wire::hardware

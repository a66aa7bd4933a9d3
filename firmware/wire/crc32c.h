#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace stof::wire {

// CRC-32C (Castagnoli): polynomial 0x1EDC6F41, reflected, starts at and is inverted with
// 0xFFFFFFFF. crc32c("123456789") == 0xE3069283; of nothing it is 0. Detects every burst of up to
// 32 bits, and all 1 to 3 bit errors at the length of our datagrams. `before` is the CRC of what
// precedes: crc32c(b, crc32c(a)) is the CRC of a followed by b.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0) noexcept;

// Without the instructions of crc32c_hardware.h: where there are none, and for tests.
namespace table {
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) noexcept;
}  // namespace table

}  // namespace stof::wire

#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "dsp/base/check.h"

// Little-endian bytes, written and read one value at a time; nothing is ever overlaid.
// Compilers turn each of these into one load or store.
namespace stof::wire {

constexpr void put_u8(std::span<std::byte, 1> to, std::uint8_t value) noexcept {
  to[0] = std::byte{value};
}
constexpr void put_u16(std::span<std::byte, 2> to, std::uint16_t value) noexcept {
  for (std::size_t i = 0; i < 2; ++i) {
    to[i] = static_cast<std::byte>(value >> (8 * i));
  }
}
constexpr void put_u32(std::span<std::byte, 4> to, std::uint32_t value) noexcept {
  for (std::size_t i = 0; i < 4; ++i) {
    to[i] = static_cast<std::byte>(value >> (8 * i));
  }
}
constexpr void put_u64(std::span<std::byte, 8> to, std::uint64_t value) noexcept {
  for (std::size_t i = 0; i < 8; ++i) {
    to[i] = static_cast<std::byte>(value >> (8 * i));
  }
}
// Signed numbers travel in two's complement.
constexpr void put_i32(std::span<std::byte, 4> to, std::int32_t value) noexcept {
  put_u32(to, static_cast<std::uint32_t>(value));
}
constexpr void put_i64(std::span<std::byte, 8> to, std::int64_t value) noexcept {
  put_u64(to, static_cast<std::uint64_t>(value));
}

constexpr std::uint8_t get_u8(std::span<const std::byte, 1> from) noexcept {
  return std::to_integer<std::uint8_t>(from[0]);
}
constexpr std::uint16_t get_u16(std::span<const std::byte, 2> from) noexcept {
  return static_cast<std::uint16_t>(std::to_integer<unsigned>(from[0]) |
                                    (std::to_integer<unsigned>(from[1]) << 8));
}
constexpr std::uint32_t get_u32(std::span<const std::byte, 4> from) noexcept {
  return std::to_integer<std::uint32_t>(from[0]) | (std::to_integer<std::uint32_t>(from[1]) << 8) |
         (std::to_integer<std::uint32_t>(from[2]) << 16) |
         (std::to_integer<std::uint32_t>(from[3]) << 24);
}
constexpr std::uint64_t get_u64(std::span<const std::byte, 8> from) noexcept {
  return std::uint64_t{get_u32(from.first<4>())} | (std::uint64_t{get_u32(from.last<4>())} << 32);
}
constexpr std::int32_t get_i32(std::span<const std::byte, 4> from) noexcept {
  return static_cast<std::int32_t>(get_u32(from));
}
constexpr std::int64_t get_i64(std::span<const std::byte, 8> from) noexcept {
  return static_cast<std::int64_t>(get_u64(from));
}

// The one place where pixels become bytes: bytes.size() == sizeof(T) * pixels.size(), one or two
// bytes a pixel.
template <typename T>
void put_pixels(std::span<std::byte> bytes, std::span<const T> pixels) noexcept {
  static_assert(sizeof(T) == 1 || std::endian::native == std::endian::little);
  STOF_CHECK(bytes.size() == pixels.size_bytes());
  if (!pixels.empty()) {
    std::memcpy(bytes.data(), pixels.data(), bytes.size());
  }
}
template <typename T>
void get_pixels(std::span<const std::byte> bytes, std::span<T> pixels) noexcept {
  static_assert(sizeof(T) == 1 || std::endian::native == std::endian::little);
  STOF_CHECK(bytes.size() == pixels.size_bytes());
  if (!pixels.empty()) {
    std::memcpy(pixels.data(), bytes.data(), bytes.size());
  }
}

}  // namespace stof::wire

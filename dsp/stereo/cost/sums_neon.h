#pragma once

#include <cstdint>

#include "dsp/base/simd.h"

// u8, u16 and u32 sums run the same kernel code: one name for all widths of an intrinsic.
// For *_neon.cpp of dsp/stereo only.
namespace stof::dsp::neon {

template <typename Sum>
struct Vector;
template <>
struct Vector<std::uint8_t> {
  using type = uint8x16_t;
  static constexpr std::size_t kLanes = 16;
};
template <>
struct Vector<std::uint16_t> {
  using type = uint16x8_t;
  static constexpr std::size_t kLanes = 8;
};
template <>
struct Vector<std::uint32_t> {
  using type = uint32x4_t;
  static constexpr std::size_t kLanes = 4;
};

inline uint8x16_t load(const std::uint8_t* p) noexcept { return vld1q_u8(p); }
inline uint16x8_t load(const std::uint16_t* p) noexcept { return vld1q_u16(p); }
inline uint32x4_t load(const std::uint32_t* p) noexcept { return vld1q_u32(p); }
inline void store(std::uint8_t* p, uint8x16_t v) noexcept { vst1q_u8(p, v); }
inline void store(std::uint16_t* p, uint16x8_t v) noexcept { vst1q_u16(p, v); }
inline void store(std::uint32_t* p, uint32x4_t v) noexcept { vst1q_u32(p, v); }
inline uint8x16_t add(uint8x16_t a, uint8x16_t b) noexcept { return vaddq_u8(a, b); }
inline uint16x8_t add(uint16x8_t a, uint16x8_t b) noexcept { return vaddq_u16(a, b); }
inline uint32x4_t add(uint32x4_t a, uint32x4_t b) noexcept { return vaddq_u32(a, b); }
inline uint8x16_t sub(uint8x16_t a, uint8x16_t b) noexcept { return vsubq_u8(a, b); }
inline uint16x8_t sub(uint16x8_t a, uint16x8_t b) noexcept { return vsubq_u16(a, b); }
inline uint32x4_t sub(uint32x4_t a, uint32x4_t b) noexcept { return vsubq_u32(a, b); }
inline uint8x16_t less(uint8x16_t a, uint8x16_t b) noexcept { return vcltq_u8(a, b); }
inline uint16x8_t less(uint16x8_t a, uint16x8_t b) noexcept { return vcltq_u16(a, b); }
inline uint32x4_t less(uint32x4_t a, uint32x4_t b) noexcept { return vcltq_u32(a, b); }
inline uint8x16_t equal(uint8x16_t a, uint8x16_t b) noexcept { return vceqq_u8(a, b); }
inline uint16x8_t equal(uint16x8_t a, uint16x8_t b) noexcept { return vceqq_u16(a, b); }
inline uint32x4_t equal(uint32x4_t a, uint32x4_t b) noexcept { return vceqq_u32(a, b); }
inline uint8x16_t smaller(uint8x16_t a, uint8x16_t b) noexcept { return vminq_u8(a, b); }
inline uint16x8_t smaller(uint16x8_t a, uint16x8_t b) noexcept { return vminq_u16(a, b); }
inline uint32x4_t smaller(uint32x4_t a, uint32x4_t b) noexcept { return vminq_u32(a, b); }
inline uint8x16_t larger(uint8x16_t a, uint8x16_t b) noexcept { return vmaxq_u8(a, b); }
inline uint16x8_t larger(uint16x8_t a, uint16x8_t b) noexcept { return vmaxq_u16(a, b); }
inline uint32x4_t larger(uint32x4_t a, uint32x4_t b) noexcept { return vmaxq_u32(a, b); }
inline uint8x16_t select(uint8x16_t m, uint8x16_t a, uint8x16_t b) noexcept {
  return vbslq_u8(m, a, b);
}
inline uint16x8_t select(uint16x8_t m, uint16x8_t a, uint16x8_t b) noexcept {
  return vbslq_u16(m, a, b);
}
inline uint32x4_t select(uint32x4_t m, uint32x4_t a, uint32x4_t b) noexcept {
  return vbslq_u32(m, a, b);
}
inline std::uint8_t smallest(uint8x16_t v) noexcept { return vminvq_u8(v); }
inline std::uint16_t smallest(uint16x8_t v) noexcept { return vminvq_u16(v); }
inline std::uint32_t smallest(uint32x4_t v) noexcept { return vminvq_u32(v); }
inline std::uint8_t largest(uint8x16_t v) noexcept { return vmaxvq_u8(v); }
inline std::uint16_t largest(uint16x8_t v) noexcept { return vmaxvq_u16(v); }
inline std::uint32_t largest(uint32x4_t v) noexcept { return vmaxvq_u32(v); }
inline uint8x16_t all(std::uint8_t v) noexcept { return vdupq_n_u8(v); }
inline uint16x8_t all(std::uint16_t v) noexcept { return vdupq_n_u16(v); }
inline uint32x4_t all(std::uint32_t v) noexcept { return vdupq_n_u32(v); }

}  // namespace stof::dsp::neon

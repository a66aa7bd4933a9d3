#pragma once

// Included in front of every *_neon.cpp by the build with STOF_PLANT_WRONG_BYTE: each vector store
// damages the lowest bit of its first element. A comparison with the reference that still passes
// compares nothing.
#include <cstdint>

#include "dsp/base/simd.h"

namespace stof::test {

// The stores that kernels use, before they are renamed below.
inline void store(std::uint8_t* p, uint8x8_t v) { vst1_u8(p, v); }
inline void store(std::uint8_t* p, uint8x16_t v) { vst1q_u8(p, v); }
inline void store(std::int16_t* p, int16x8_t v) { vst1q_s16(p, v); }
inline void store(std::uint16_t* p, uint16x4_t v) { vst1_u16(p, v); }
inline void store(std::uint16_t* p, uint16x8_t v) { vst1q_u16(p, v); }
inline void store(std::int32_t* p, int32x4_t v) { vst1q_s32(p, v); }
inline void store(std::uint32_t* p, uint32x4_t v) { vst1q_u32(p, v); }

template <typename T, typename V>
void planted_store(T* p, V v) {
  store(p, v);
  *p = static_cast<T>(*p ^ T{1});
}

}  // namespace stof::test

#undef vst1_u8
#undef vst1q_u8
#undef vst1q_s16
#undef vst1_u16
#undef vst1q_u16
#undef vst1q_s32
#undef vst1q_u32
#define vst1_u8 ::stof::test::planted_store
#define vst1q_u8 ::stof::test::planted_store
#define vst1q_s16 ::stof::test::planted_store
#define vst1_u16 ::stof::test::planted_store
#define vst1q_u16 ::stof::test::planted_store
#define vst1q_s32 ::stof::test::planted_store
#define vst1q_u32 ::stof::test::planted_store

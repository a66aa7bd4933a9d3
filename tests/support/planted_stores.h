#pragma once

// Included in front of every *_neon.cpp by the build with STOF_PLANT_WRONG_BYTE: each vector store
// damages its first element (dsp/base/planted.h). scripts/check_layers.py refuses a store that is not
// in here.
#include "dsp/base/planted.h"
#include "dsp/base/simd.h"

namespace stof::test {

// Vectors of the vocabulary are those of the compiler: a whole one is written as it lies in memory.
template <typename T, typename V>
void planted_store(T* p, V v) {
  __builtin_memcpy(p, &v, sizeof v);
  dsp::damage(p);
}
// One lane.
template <typename T, typename V>
void planted_lane(T* p, V v, int lane) {
  __builtin_memcpy(p, reinterpret_cast<const T*>(&v) + lane, sizeof *p);
  dsp::damage(p);
}

}  // namespace stof::test

#undef vst1_u8
#undef vst1q_u8
#undef vst1q_s16
#undef vst1_u16
#undef vst1q_u16
#undef vst1q_s32
#undef vst1q_u32
#undef vst1_u64
#undef vst1q_lane_u8
#undef vst1q_lane_u16
#define vst1_u8 ::stof::test::planted_store
#define vst1q_u8 ::stof::test::planted_store
#define vst1q_s16 ::stof::test::planted_store
#define vst1_u16 ::stof::test::planted_store
#define vst1q_u16 ::stof::test::planted_store
#define vst1q_s32 ::stof::test::planted_store
#define vst1q_u32 ::stof::test::planted_store
#define vst1_u64 ::stof::test::planted_store
#define vst1q_lane_u8 ::stof::test::planted_lane
#define vst1q_lane_u16 ::stof::test::planted_lane

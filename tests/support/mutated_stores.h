#pragma once

// Included in front of every *_neon.cpp by the build with STOF_MUTATE_STORES: each vector store
// mutates its first element (dsp/base/mutation.h). scripts/check_layers.py refuses a store that is
// not in here.
#include "dsp/base/mutation.h"
#include "dsp/base/simd.h"

namespace stof::test {

// Vectors of the vocabulary are those of the compiler: a whole one is written as it lies in memory.
template <typename T, typename V>
void mutated_store(T* p, V v) {
  __builtin_memcpy(p, &v, sizeof v);
  dsp::mutate(p);
}
// One lane.
template <typename T, typename V>
void mutated_lane(T* p, V v, int lane) {
  __builtin_memcpy(p, reinterpret_cast<const T*>(&v) + lane, sizeof *p);
  dsp::mutate(p);
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
#define vst1_u8 ::stof::test::mutated_store
#define vst1q_u8 ::stof::test::mutated_store
#define vst1q_s16 ::stof::test::mutated_store
#define vst1_u16 ::stof::test::mutated_store
#define vst1q_u16 ::stof::test::mutated_store
#define vst1q_s32 ::stof::test::mutated_store
#define vst1q_u32 ::stof::test::mutated_store
#define vst1_u64 ::stof::test::mutated_store
#define vst1q_lane_u8 ::stof::test::mutated_lane
#define vst1q_lane_u16 ::stof::test::mutated_lane

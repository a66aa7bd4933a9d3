#pragma once

// The only place that knows which variant of a kernel this build runs. Every kernel has a `ref`
// (the meaning, plain as the formula) and a `neon` (equal to it, bit for bit; through SIMDe on
// x86). Callers write best::kernel(...).
namespace stof::dsp {

namespace ref {}
namespace neon {}
#if defined(STOF_PLAIN)  // target stof_dsp_plain, to compare with
namespace best = ref;
#else
namespace best = neon;
#endif

// How many bits of a census descriptor lie in one byte (stereo/cost/census.h): ARM counts the bits
// of bytes, other processors look up the distance of four bits.
#if defined(__aarch64__)
inline constexpr int kPlaneBits = 8;
#else
inline constexpr int kPlaneBits = 4;
#endif

}  // namespace stof::dsp

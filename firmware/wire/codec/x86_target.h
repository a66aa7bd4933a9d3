#pragma once

#include "dsp/base/target.h"

// Functions marked STOF_WIRE_AVX2 are compiled, with all that they call, for x86 processors that
// have AVX2 and BMI2. They say the same as what is compiled for all: shifts that take one step and
// vectors twice as long are all that differs.
namespace stof::wire {

#if defined(__x86_64__)
#define STOF_WIRE_AVX2 [[gnu::target("avx2,bmi,bmi2"), gnu::flatten]]
// Whether they run: where kernels for AVX2 do.
inline bool uses_avx2() noexcept { return dsp::vectors() >= dsp::Vectors::kAvx2; }
#else
#define STOF_WIRE_AVX2
constexpr bool uses_avx2() noexcept { return false; }
#endif

}  // namespace stof::wire

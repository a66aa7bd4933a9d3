#include "dsp/base/target.h"

#include "dsp/base/check.h"

#if !defined(STOF_NEON_ALONE)
namespace stof::dsp {
namespace {

// Others may ask before main().
Vectors& chosen() noexcept {
  static Vectors vectors = widest_vectors();
  return vectors;
}

}  // namespace

Vectors widest_vectors() noexcept {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") == 0 || __builtin_cpu_supports("bmi") == 0 ||
      __builtin_cpu_supports("bmi2") == 0) {
    return Vectors::kNeon;
  }
  return __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0
             ? Vectors::kAvx512
             : Vectors::kAvx2;
#else
  return Vectors::kNeon;
#endif
}

void use_vectors(Vectors vectors) noexcept {
  STOF_CHECK(vectors <= widest_vectors());
  chosen() = vectors;
}

Vectors vectors() noexcept { return chosen(); }

}  // namespace stof::dsp
#endif

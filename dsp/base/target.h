#pragma once

#include <cstddef>
#include <cstdint>

// The only place that knows which variant of a kernel runs. Every kernel has a `ref` (the meaning,
// plain as the formula) and a `neon` (equal to it, bit for bit; through SIMDe on x86). Those that
// dominate the frame on x86 have an `avx2` too, equal again, and some an `avx512`.
// kernel.h declares them; callers write best::kernel(...).
namespace stof::dsp {

// In order: what has no variant for one runs with the one before. kAvx2 has BMI2 too, kAvx512 bytes
// and words.
enum class Vectors : std::uint8_t { kRef, kNeon, kAvx2, kAvx512 };
inline constexpr std::size_t kVectorLevels = 4;
// The levels that this build holds.
#if defined(__x86_64__)
inline constexpr Vectors kWidestBuilt = Vectors::kAvx512;
#else
inline constexpr Vectors kWidestBuilt = Vectors::kNeon;
#endif

// Host, tests and x86 choose at run time. In an appliance for ARM, STOF_NEON_ALONE, best:: calls
// the NEON function, and the linker drops every reference that no NEON tail needs.
#if !defined(STOF_NEON_ALONE)
// The widest that this processor runs.
Vectors widest_vectors() noexcept;
// Chooses what best:: kernels run with; the widest, unless a comparison asks for less. Not while
// another thread computes.
void use_vectors(Vectors vectors) noexcept;
Vectors vectors() noexcept;

// best:: kernels run with these in its scope.
class UseVectors {
 public:
  explicit UseVectors(Vectors with) noexcept : before_(vectors()) { use_vectors(with); }
  ~UseVectors() { use_vectors(before_); }
  UseVectors(const UseVectors&) = delete;
  UseVectors& operator=(const UseVectors&) = delete;

 private:
  Vectors before_;
};
#endif

// How many bits of a census descriptor lie in one byte (stereo/cost/census.h): ARM counts the bits
// of bytes, other processors look up the distance of four bits.
#if defined(__aarch64__)
inline constexpr int kPlaneBits = 8;
#else
inline constexpr int kPlaneBits = 4;
#endif

}  // namespace stof::dsp

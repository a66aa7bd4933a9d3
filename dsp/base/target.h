#pragma once

#include <cstdint>

// The only place that knows which variant of a kernel runs. Every kernel has a `ref` (the meaning,
// plain as the formula) and a `neon` (equal to it, bit for bit; through SIMDe on x86). Those that
// dominate the frame on x86 have an `avx2` too, equal again, and the block searches an `avx512`;
// they are chosen at start where the processor has them. Callers write best::kernel(...).
namespace stof::dsp {

namespace ref {}
namespace neon {}
namespace avx2 {}
namespace avx512 {}

// In order: what has no variant for one runs with the one before. kAvx512 has bytes and words too.
enum class Vectors : std::uint8_t { kNeon, kAvx2, kAvx512 };

// The widest that this processor runs.
Vectors widest_vectors() noexcept;
// What best:: kernels run with: the widest, unless a benchmark or a test asks for less. Not while
// another thread computes.
void use_vectors(Vectors vectors) noexcept;
Vectors vectors() noexcept;

// Kernels without an avx2 variant. What has one is declared as a Kernel beside it, which hides the
// neon one:
//   namespace best { inline constexpr Kernel<Phase> phase{STOF_VARIANTS(phase)}; }
namespace best {
#if defined(STOF_PLAIN)  // target stof_dsp_plain, to compare with
using namespace ref;     // NOLINT(google-build-using-namespace): what this namespace is
#else
using namespace neon;  // NOLINT(google-build-using-namespace): what this namespace is
#endif
}  // namespace best

// One signature, R(A...) noexcept, and its variants; the wide ones may be nullptr.
template <typename Signature>
struct Variants;
template <typename R, typename... A>
struct Variants<R(A...) noexcept> {
  using Function = R(A...) noexcept;

  Function* ref;
  Function* neon;
  Function* avx2 = nullptr;
  Function* avx512 = nullptr;

  R operator()(A... a) const noexcept {
#if defined(STOF_PLAIN)
    return ref(a...);
#else
    const Vectors with = vectors();
    if (avx512 != nullptr && with == Vectors::kAvx512) {
      return avx512(a...);
    }
    return avx2 != nullptr && with != Vectors::kNeon ? avx2(a...) : neon(a...);
#endif
  }
};

// All signatures that go by one name, in the order of its initialisers.
template <typename... Signatures>
struct Kernel : Variants<Signatures>... {
  using Variants<Signatures>::operator()...;
};

// The variants of an overload of `name`, of which the place decides.
#if defined(__x86_64__)
#define STOF_VARIANTS(name) {ref::name, neon::name, avx2::name}
#define STOF_ALL_VARIANTS(name) {ref::name, neon::name, avx2::name, avx512::name}
#else
#define STOF_VARIANTS(name) STOF_PORTABLE(name)
#define STOF_ALL_VARIANTS(name) STOF_PORTABLE(name)
#endif
// Of one that has no wide ones.
#define STOF_PORTABLE(name) {ref::name, neon::name}

// How many bits of a census descriptor lie in one byte (stereo/cost/census.h): ARM counts the bits
// of bytes, other processors look up the distance of four bits.
#if defined(__aarch64__)
inline constexpr int kPlaneBits = 8;
#else
inline constexpr int kPlaneBits = 4;
#endif

}  // namespace stof::dsp

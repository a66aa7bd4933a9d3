#pragma once

#include <span>

// What a build with STOF_PLANT_WRONG_BYTE does to results: the lowest bit of the first element is
// wrong, and the kernel's test must notice. Vector stores do it by themselves: those of NEON are
// replaced by tests/support/planted_stores.h, wide ones are in avx2.h. A kernel that writes lane by
// lane calls damage(). static: a wide file's copy must not serve others.
namespace stof::dsp {

template <typename T>
static inline void damage([[maybe_unused]] T* written) noexcept {
#if defined(STOF_PLANT_WRONG_BYTE)
  *written = static_cast<T>(*written ^ T{1});
#endif
}
template <typename T>
static inline void damage(std::span<T> written) noexcept {
  if (!written.empty()) {
    damage(written.data());
  }
}

}  // namespace stof::dsp

#pragma once

#include <span>

// Mutation testing: in a build with STOF_MUTATE_STORES the lowest bit of the first element that a
// kernel stores is wrong, and the kernel's test must notice. Vector stores mutate by themselves:
// tests/support/mutated_stores.h replaces those of NEON, wide ones are in avx2.h. A kernel that
// writes lane by lane calls mutate(). static: a wide file's copy must not serve others.
namespace stof::dsp {

template <typename T>
static inline void mutate([[maybe_unused]] T* written) noexcept {
#if defined(STOF_MUTATE_STORES)
  *written = static_cast<T>(*written ^ T{1});
#endif
}
template <typename T>
static inline void mutate(std::span<T> written) noexcept {
  if (!written.empty()) {
    mutate(written.data());
  }
}

// Takes back what a vector store did, where an index is made of what was stored and a wrong one
// would end the program. The kernel mutates its result instead.
template <typename T>
static inline void unmutate(T* written) noexcept {
  mutate(written);
}

}  // namespace stof::dsp

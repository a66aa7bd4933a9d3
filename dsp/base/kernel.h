#pragma once

#include <array>
#include <cstddef>

#include "dsp/base/target.h"

// How a header declares a kernel: one line for all variants.
namespace stof::dsp {

// One signature, R(A...) noexcept, and the function of each level.
template <typename Signature>
struct Variants;
template <typename R, typename... A>
struct Variants<R(A...) noexcept> {
  using Function = R(A...) noexcept;

#if !defined(STOF_NEON_ALONE)
  constexpr Variants(Function& ref, Function& neon, Function& avx2, Function& avx512) noexcept
      : levels{ref, neon, avx2, avx512} {}
  R operator()(A... a) const noexcept { return levels[static_cast<std::size_t>(vectors())](a...); }

  std::array<Function*, kVectorLevels> levels;
#else
  constexpr Variants(Function& /*ref*/, Function& neon, Function& /*avx2*/,
                     Function& /*avx512*/) noexcept
      : function(neon) {}
  R operator()(A... a) const noexcept { return function(a...); }

  Function* function;
#endif
};
template <typename R, typename... A, typename... More>
Variants(R (&)(A...) noexcept, More&...) -> Variants<R(A...) noexcept>;

// All signatures that go by one name.
template <typename... Signatures>
struct Kernel : Variants<Signatures>... {
  using Variants<Signatures>::operator()...;
};
template <typename... Signatures>
Kernel(Variants<Signatures>...) -> Kernel<Signatures...>;

// The widest variant that a kernel template has for a type.
template <typename T, Vectors kOf>
struct WidestOf {
  using Type = T;
  static constexpr Vectors kWidest = kOf;
};
template <typename T>
using Neon = WidestOf<T, Vectors::kNeon>;
template <typename T>
using Avx2 = WidestOf<T, Vectors::kAvx2>;
template <typename T>
using Avx512 = WidestOf<T, Vectors::kAvx512>;

template <typename... WidestOfTypes, typename VariantsOf>
constexpr auto overloads(VariantsOf variants_of) noexcept {
  return Kernel { variants_of.template operator()<WidestOfTypes>()... };
}

constexpr bool built_with(Vectors widest, Vectors level) noexcept {
  return level <= widest && level <= kWidestBuilt;
}

// Declares a kernel of one signature, `widest` (of Vectors) its widest variant: a function in ref,
// neon and on, and best::name, which calls the one that the processor has.
//   STOF_KERNEL(PhaseKernel, phase, kAvx2)
// NOLINTBEGIN(bugprone-macro-parentheses,cppcoreguidelines-macro-usage): they declare
// NOLINTBEGIN(readability-identifier-naming): a kernel is called, and named, as a function is
#define STOF_KERNEL(Signature, name, widest)                                                     \
  STOF_IN_EACH_VARIANT(Signature name)                                                           \
  namespace best {                                                                               \
  inline constexpr Kernel name{[]() noexcept { STOF_RETURN_VARIANTS(Vectors::widest, name) }()}; \
  }
// The same of a function template: instantiated for each type, up to its widest variant.
//   STOF_KERNELS(Winners, winners, Avx2<std::uint8_t>, Neon<std::uint32_t>)
// A variant's source defines the template and ends with a line for it:
//   STOF_INSTANTIATE(Winners, winners, std::uint8_t, std::uint32_t);
#define STOF_KERNELS(Signature, name, ...)                                             \
  STOF_IN_EACH_VARIANT(template <typename T> Signature<T> name)                        \
  namespace best {                                                                     \
  inline constexpr auto name = overloads<__VA_ARGS__>([]<typename Widest>() noexcept { \
    STOF_RETURN_VARIANTS(Widest::kWidest, name<typename Widest::Type>)                 \
  });                                                                                  \
  }
#define STOF_IN_EACH_VARIANT(...) \
  namespace ref {                 \
  __VA_ARGS__;                    \
  }                               \
  namespace neon {                \
  __VA_ARGS__;                    \
  }                               \
  namespace avx2 {                \
  __VA_ARGS__;                    \
  }                               \
  namespace avx512 {              \
  __VA_ARGS__;                    \
  }
#define STOF_RETURN_VARIANTS(widest, name)                            \
  if constexpr (built_with(widest, Vectors::kAvx512)) {               \
    return Variants(ref::name, neon::name, avx2::name, avx512::name); \
  } else if constexpr (built_with(widest, Vectors::kAvx2)) {          \
    return Variants(ref::name, neon::name, avx2::name, avx2::name);   \
  } else {                                                            \
    return Variants(ref::name, neon::name, neon::name, neon::name);   \
  }
// For one to three types.
#define STOF_INSTANTIATE(Signature, name, T, ...) \
  template Signature<T> name<T> __VA_OPT__(; STOF_INSTANTIATE_TWO(Signature, name, __VA_ARGS__))
#define STOF_INSTANTIATE_TWO(Signature, name, T, ...) \
  template Signature<T> name<T> __VA_OPT__(; STOF_INSTANTIATE_ONE(Signature, name, __VA_ARGS__))
#define STOF_INSTANTIATE_ONE(Signature, name, T) template Signature<T> name<T>
// NOLINTEND(readability-identifier-naming)
// NOLINTEND(bugprone-macro-parentheses,cppcoreguidelines-macro-usage)

}  // namespace stof::dsp

#pragma once

#include <cstdint>
#include <span>
#include <type_traits>

#include "dsp/base/random.h"

namespace stof::test {

// splitmix64: the same numbers on every machine. Print the seed in failure messages.
class Random {
 public:
  explicit Random(std::uint64_t seed) noexcept : source_(seed) {}

  std::uint64_t next() noexcept { return source_.next(); }
  // Uniform in [low, high].
  int between(int low, int high) noexcept {
    const std::uint64_t count = static_cast<std::uint64_t>(std::int64_t{high} - low) + 1;
    return static_cast<int>(low + static_cast<std::int64_t>(next() % count));
  }
  template <typename T>
  void fill(std::span<T> out, int low, int high) noexcept {
    for (T& value : out) {
      value = static_cast<T>(between(low, high));
    }
  }
  template <typename T>
  void fill(std::span<T> out) noexcept {
    static_assert(std::is_integral_v<T>);
    for (T& value : out) {
      value = static_cast<T>(next());
    }
  }

 private:
  dsp::SplitMix64 source_;
};

}  // namespace stof::test

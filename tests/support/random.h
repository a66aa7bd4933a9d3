#pragma once

#include <cstdint>
#include <span>
#include <type_traits>

namespace stof::test {

// splitmix64: the same numbers on every machine. Print the seed in failure messages.
class Random {
 public:
  explicit Random(std::uint64_t seed) noexcept : state_(seed) {}

  std::uint64_t next() noexcept {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }
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
  std::uint64_t state_;
};

}  // namespace stof::test

#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/stereo/match_params.h"

namespace stof::dsp {

// One bit for each pixel of a row of up to kMaxImageWidth. Not initialised: every word of a row of
// n pixels is put first, with 0 behind the last pixel.
class PixelSet {
 public:
  static constexpr std::size_t kWord = 64;

  // Those of n pixels.
  std::span<std::uint64_t> words(std::size_t n) noexcept {
    return std::span(words_).first((n + kWord - 1) / kWord);
  }
  // Pixels x .. x + 7, the first lowest; x a multiple of 8.
  unsigned eight(std::size_t x) const noexcept {
    return static_cast<unsigned>(words_[x / kWord] >> (x % kWord)) & 0xFFU;
  }
  void add(std::size_t x) noexcept { words_[x / kWord] |= std::uint64_t{1} << (x % kWord); }
  void remove(std::size_t x) noexcept { words_[x / kWord] &= ~(std::uint64_t{1} << (x % kWord)); }
  void unite(const PixelSet& other, std::size_t n) noexcept {
    for (std::size_t word = 0; word * kWord < n; ++word) {
      words_[word] |= other.words_[word];
    }
  }
  void intersect(const PixelSet& other, std::size_t n) noexcept {
    for (std::size_t word = 0; word * kWord < n; ++word) {
      words_[word] &= other.words_[word];
    }
  }
  bool has(std::size_t x) const noexcept { return ((words_[x / kWord] >> (x % kWord)) & 1) != 0; }

  // The first pixel at x or behind that is in the set (or not in it); n where there is none.
  std::size_t next(std::size_t x, std::size_t n) const noexcept { return find(x, n, 0); }
  std::size_t next_without(std::size_t x, std::size_t n) const noexcept {
    return find(x, n, ~std::uint64_t{0});
  }
  // Calls visit(x) for those of n pixels, from the first on. It may take out pixels that were
  // visited.
  template <typename Visit>
  void each(std::size_t n, Visit visit) const noexcept {
    for (std::size_t word = 0; word * kWord < n; ++word) {
      for (std::uint64_t bits = words_[word]; bits != 0; bits &= bits - 1) {
        visit(word * kWord + static_cast<std::size_t>(std::countr_zero(bits)));
      }
    }
  }
  // The last pixel before x that is in the set; x where there is none.
  std::size_t before(std::size_t x) const noexcept {
    if (x == 0) {
      return x;
    }
    std::size_t word = (x - 1) / kWord;
    std::uint64_t bits = words_[word] & (~std::uint64_t{0} >> (kWord - 1 - (x - 1) % kWord));
    while (bits == 0 && word > 0) {
      bits = words_[--word];
    }
    return bits == 0 ? x
                     : word * kWord + kWord - 1 - static_cast<std::size_t>(std::countl_zero(bits));
  }

 private:
  std::size_t find(std::size_t x, std::size_t n, std::uint64_t invert) const noexcept {
    if (x >= n) {
      return n;
    }
    std::size_t word = x / kWord;
    std::uint64_t bits = (words_[word] ^ invert) & (~std::uint64_t{0} << (x % kWord));
    while (bits == 0 && (word + 1) * kWord < n) {
      bits = words_[++word] ^ invert;
    }
    return bits == 0 ? n
                     : std::min(word * kWord + static_cast<std::size_t>(std::countr_zero(bits)), n);
  }

  std::array<std::uint64_t, static_cast<std::size_t>(kMaxImageWidth) / kWord> words_;
};

}  // namespace stof::dsp

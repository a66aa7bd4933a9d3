#include "dsp/fusion/temporal/cell_change.h"

#include <cstddef>

#include "dsp/base/avx2.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kCells = 8;  // at once

// Of 32 bytes, sums of pairs.
i16x16 pairs(u8x32 v) noexcept {
  return as<i16x16>(_mm256_maddubs_epi16(bits(v), _mm256_set1_epi8(1)));
}

// Of two pairs.
__m256i cells(i16x16 v) noexcept { return _mm256_madd_epi16(bits(v), _mm256_set1_epi16(1)); }

}  // namespace

void cell_change(const CellRows& now, const CellRows& then,
                 std::span<std::uint8_t> changed) noexcept {
  check_cell_change(now, then, changed);
  std::size_t i = 0;
  for (; i + kCells <= changed.size(); i += kCells) {
    i16x16 sum{};
    i16x16 apart{};
    for (std::size_t k = 0; k < now.size(); ++k) {
      const u8x32 a = load<u8x32>(now[k].data() + kCellSize * i);
      const u8x32 b = load<u8x32>(then[k].data() + kCellSize * i);
      sum += pairs(a) - pairs(b);
      apart += pairs(larger(a, b) - smaller(a, b));
    }
    const __m256i far = _mm256_or_si256(
        _mm256_cmpgt_epi32(_mm256_abs_epi32(cells(sum)), _mm256_set1_epi32(kCellSumStep)),
        _mm256_cmpgt_epi32(cells(apart), _mm256_set1_epi32(kCellPixelStep)));
    const __m128i words =
        _mm_packs_epi32(_mm256_castsi256_si128(far), _mm256_extracti128_si256(far, 1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(changed.data() + i),  // NOLINT: any type
                     _mm_packs_epi16(words, words));
    mutate(changed.data() + i);
  }
  const auto behind = [i](const CellRows& rows) noexcept {
    CellRows tail = rows;
    for (std::span<const std::uint8_t>& row : tail) {
      row = row.subspan(kCellSize * i);
    }
    return tail;
  };
  neon::cell_change(behind(now), behind(then), changed.subspan(i));
}

}  // namespace stof::dsp::avx2

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/stereo/search/block_vectors_avx2.h"
#include "dsp/stereo/search/block_winners.h"

// Winners and fits of sixteen columns, for the AVX2 and AVX-512 variants of block_winners(): a
// template, so that each has its own. See block_winners_body.h.
namespace stof::dsp::avx2 {

template <typename Isa>
struct Eights : BlockVectors<Isa> {  // NOLINT(bugprone-crtp-constructor-accessibility)
  static constexpr std::size_t kColumns = 16;

  static bool lowest(const std::uint16_t* eights, std::size_t first, std::uint16_t* costs,
                     std::int16_t* winners) noexcept {
    const auto found = lowest_of_each(eights, eights + 64);
    const __m256i group = _mm256_slli_epi16(_mm256_and_si256(found.sums, words(7)), 3);
    __m256i winner = _mm256_add_epi16(_mm256_add_epi16(group, found.lanes),
                                      words(static_cast<std::int16_t>(first & ~63U)));
    __m256i cost = _mm256_srli_epi16(found.sums, 3);  // below 2^15: signed comparisons will do
    if (first != 0) {
      const __m256i before = get(costs);
      const __m256i better = _mm256_cmpgt_epi16(before, cost);
      cost = _mm256_min_epu16(cost, before);
      winner = _mm256_blendv_epi8(get(winners), winner, better);
    }
    put(costs, cost);
    put(winners, winner);
    return _mm256_movemask_epi8(_mm256_cmpgt_epi16(words(1), winner)) != 0;
  }

  // Parts less 32768, which products add up in pairs.
  static void add_parts(const std::uint16_t* parts, std::size_t first,
                        std::uint32_t* totals) noexcept {
    const auto pairs = [&](int k) noexcept {
      return _mm_madd_epi16(_mm_xor_si128(get_half(parts + 8 * k), _mm_set1_epi16(-32768)),
                            _mm_set1_epi16(1));
    };
    __m128i sums =
        _mm_hadd_epi32(_mm_hadd_epi32(pairs(0), pairs(1)), _mm_hadd_epi32(pairs(2), pairs(3)));
    sums = _mm_add_epi32(sums, _mm_set1_epi32(8 * 32768));
    put(totals, first == 0 ? sums : _mm_add_epi32(sums, get_half(totals)));
  }

  template <int kShift>
  static void fit(const BlockRow& row, const std::uint16_t* columns,
                  const std::array<std::uint16_t, kColumns>& places, const std::uint16_t* costs,
                  const std::int16_t* winners, std::int16_t* kept, std::int16_t* fitted) noexcept {
    const __m256i winner = get(winners);
    const __m256i base =
        _mm256_add_epi16(winner, words(static_cast<std::int16_t>(row.min_disparity)));
    __m256i out = _mm256_slli_epi16(base, Disparity::kFractionBits);
    if (row.fit != CostFit::kNone) {
      const std::uint16_t* around[kColumns];
      for (std::size_t k = 0; k < kColumns; ++k) {
        around[k] = columns + places[k] + winners[k] - 1;
      }
      const auto low = gather(around);
      const auto high = gather(around + 8);
      __m256i before = _mm256_set_m128i(high.before, low.before);
      __m256i after = _mm256_set_m128i(high.after, low.after);
      // Where none are missing, costs are below 2^15.
      const __m256i missing = _mm256_cmpeq_epi16(_mm256_max_epu16(before, after), words(-1));
      before = _mm256_srli_epi16(before, kShift);
      after = _mm256_srli_epi16(after, kShift);
      const __m256i last = words(static_cast<std::int16_t>(row.lanes - 1));
      const __m256i inside = _mm256_and_si256(_mm256_cmpgt_epi16(winner, _mm256_setzero_si256()),
                                              _mm256_cmpgt_epi16(last, winner));
      const __m256i usable = _mm256_andnot_si256(missing, inside);
      const __m256i shift =
          _mm256_and_si256(sixteenths(before, get(costs), after, row.fit), usable);
      // Minus where the candidate before is the cheaper one; 0 stays where they are equal.
      out = _mm256_add_epi16(out, _mm256_sign_epi16(shift, _mm256_sub_epi16(before, after)));
    }
    const __m256i none = _mm256_cmpeq_epi16(winner, words(kNoWinner));
    put(kept, winner);
    put(fitted, _mm256_blendv_epi8(out, words(Disparity::none().raw), none));
  }

 protected:
  using Vectors = BlockVectors<Isa>;
  using Vectors::gather, Vectors::get, Vectors::get_half, Vectors::lowest_of_each, Vectors::put,
      Vectors::sixteenths, Vectors::words;
};

}  // namespace stof::dsp::avx2

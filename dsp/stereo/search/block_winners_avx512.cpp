#include "dsp/base/avx2.h"
#include "dsp/stereo/search/block_eights_avx2.h"
#include "dsp/stereo/search/block_fits_body.h"

namespace stof::dsp::avx512 {
namespace {

struct Avx512 : avx2::Eights<Avx512> {
  using V = __m512i;
  static constexpr std::size_t kLanes = 32;

  static V load(const std::uint16_t* p) noexcept { return _mm512_loadu_si512(p); }
  static void store(std::uint16_t* p, V v) noexcept {
    avx2::store_bits(p, v);
    unmutate(p);
  }
  static V add(V a, V b) noexcept { return _mm512_add_epi16(a, b); }
  static V sub(V a, V b) noexcept { return _mm512_sub_epi16(a, b); }
  static V smaller(V a, V b) noexcept { return _mm512_min_epu16(a, b); }
  static V without(V a, V b) noexcept { return _mm512_andnot_si512(b, a); }
  static V either(V a, V b) noexcept { return _mm512_or_si512(a, b); }
  static V eighth(V a) noexcept { return _mm512_srli_epi16(a, 3); }
  static V numbers(std::size_t v) noexcept {
    const V quarters = _mm512_set_epi64(3, 3, 2, 2, 1, 1, 0, 0);  // one in each word of a quarter
    const V words = _mm512_or_si512(quarters, _mm512_slli_epi64(quarters, 16));
    return _mm512_add_epi16(_mm512_or_si512(words, _mm512_slli_epi64(words, 32)),
                            _mm512_set1_epi16(static_cast<std::int16_t>(4 * v)));
  }
  static void store_eight(std::uint16_t* p, V v) noexcept {
    const __m256i half =
        _mm256_min_epu16(_mm512_castsi512_si256(v), _mm512_extracti64x4_epi64(v, 1));
    put(p, _mm_min_epu16(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1)));
  }
  static void store_parts(std::uint16_t* p, V v) noexcept {
    const __m256i half =
        _mm256_add_epi16(_mm512_castsi512_si256(v), _mm512_extracti64x4_epi64(v, 1));
    put(p, _mm_add_epi16(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1)));
  }

  static V outside(int first, int begin, int end) noexcept {
    const __m256i bytes =
        _mm256_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20,
                         21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31);
    // Less `begin`, wrapped, those inside are below the number of candidates.
    const V candidate = _mm512_add_epi16(
        _mm512_cvtepu8_epi16(bytes), _mm512_set1_epi16(static_cast<std::int16_t>(first - begin)));
    const V count = _mm512_set1_epi16(static_cast<std::int16_t>(std::max(end - begin, 0)));
    return _mm512_movm_epi16(_mm512_cmpge_epu16_mask(candidate, count));
  }

  static V pixel(const std::uint8_t* p) noexcept { return _mm512_set1_epi8(static_cast<char>(*p)); }
  using Change = V;
  static V change(V in, const std::uint8_t* new_right, V gone,
                  const std::uint8_t* old_right) noexcept {
    const V entering = _mm512_abs_epi8(_mm512_sub_epi8(in, _mm512_loadu_si512(new_right)));
    const V leaving = _mm512_abs_epi8(_mm512_sub_epi8(gone, _mm512_loadu_si512(old_right)));
    return _mm512_sub_epi8(entering, leaving);
  }
  static void add_change(V change, V& a, V& b) noexcept {
    const V low = _mm512_cvtepi8_epi16(_mm512_castsi512_si256(change));
    const V high = _mm512_cvtepi8_epi16(_mm512_extracti64x4_epi64(change, 1));
    a = _mm512_add_epi16(a, _mm512_slli_epi16(low, 3));
    b = _mm512_add_epi16(b, _mm512_slli_epi16(high, 3));
  }
};

}  // namespace

void block_winners(const BlockPixels& pixels, const BlockRow& row, std::span<std::uint16_t> columns,
                   const BlockMatches& out) noexcept {
  if (row.lanes % 64 != 0) {
    avx2::block_winners(pixels, row, columns, out);
    return;
  }
  block_winners_body::pass<Avx512>(pixels, row, columns, out);
}

}  // namespace stof::dsp::avx512

#include "dsp/base/avx2.h"
#include "dsp/stereo/search/block_eights_avx2.h"
#include "dsp/stereo/search/block_fits_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Avx2 : Eights<Avx2> {
  using V = __m256i;
  static constexpr std::size_t kLanes = 16;

  static V load(const std::uint16_t* p) noexcept { return bits(avx2::load<u16x16>(p)); }
  static void store(std::uint16_t* p, V v) noexcept {
    avx2::store(p, as<u16x16>(v));
    unmutate(p);
  }
  static V add(V a, V b) noexcept { return _mm256_add_epi16(a, b); }
  static V sub(V a, V b) noexcept { return _mm256_sub_epi16(a, b); }
  static V smaller(V a, V b) noexcept { return _mm256_min_epu16(a, b); }
  static V without(V a, V b) noexcept { return _mm256_andnot_si256(b, a); }
  static V either(V a, V b) noexcept { return _mm256_or_si256(a, b); }
  static V eighth(V a) noexcept { return _mm256_srli_epi16(a, 3); }
  static V numbers(std::size_t v) noexcept {
    const auto low = static_cast<std::int16_t>(2 * v);
    const auto high = static_cast<std::int16_t>(2 * v + 1);
    return _mm256_set_m128i(_mm_set1_epi16(high), _mm_set1_epi16(low));
  }
  static void store_eight(std::uint16_t* p, V v) noexcept {
    put(p, _mm_min_epu16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1)));
  }
  static void store_parts(std::uint16_t* p, V v) noexcept {
    put(p, _mm_add_epi16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1)));
  }

  static V outside(int first, int begin, int end) noexcept {
    const V number = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    // Less `begin`, wrapped, those inside are below the number of candidates.
    const V candidate =
        _mm256_add_epi16(number, _mm256_set1_epi16(static_cast<std::int16_t>(first - begin)));
    const V count = _mm256_set1_epi16(static_cast<std::int16_t>(std::max(end - begin, 0)));
    return _mm256_cmpeq_epi16(_mm256_max_epu16(candidate, count), candidate);
  }

  static V pixel(const std::uint8_t* p) noexcept { return bits(all(*p)); }
  using Change = V;
  static V change(V in, const std::uint8_t* new_right, V gone,
                  const std::uint8_t* old_right) noexcept {
    const V entering = _mm256_abs_epi8(_mm256_sub_epi8(in, bits(avx2::load<u8x32>(new_right))));
    const V leaving = _mm256_abs_epi8(_mm256_sub_epi8(gone, bits(avx2::load<u8x32>(old_right))));
    return _mm256_sub_epi8(entering, leaving);
  }
  static void add_change(V of, V& a, V& b) noexcept {
    // Unpacked, quarters 0 2 1 3 are in order. 256 times the change, then 8 times.
    const V change = _mm256_permute4x64_epi64(of, 0xD8);
    const V zero = _mm256_setzero_si256();
    a = _mm256_add_epi16(a, _mm256_srai_epi16(_mm256_unpacklo_epi8(zero, change), 5));
    b = _mm256_add_epi16(b, _mm256_srai_epi16(_mm256_unpackhi_epi8(zero, change), 5));
  }
  static void exchange(V in, const std::uint8_t* new_right, V gone, const std::uint8_t* old_right,
                       V& a) noexcept {
    const __m128i entering =
        _mm_abs_epi8(_mm_sub_epi8(_mm256_castsi256_si128(in), get_half(new_right)));
    const __m128i leaving =
        _mm_abs_epi8(_mm_sub_epi8(_mm256_castsi256_si128(gone), get_half(old_right)));
    const V change = _mm256_cvtepi8_epi16(_mm_sub_epi8(entering, leaving));
    a = _mm256_add_epi16(a, _mm256_slli_epi16(change, 3));
  }
};

}  // namespace

void block_winners(const BlockPixels& pixels, const BlockRow& row, std::span<std::uint16_t> columns,
                   const BlockMatches& out) noexcept {
  block_winners_body::pass<Avx2>(pixels, row, columns, out);
}

}  // namespace stof::dsp::avx2

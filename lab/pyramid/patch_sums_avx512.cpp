#include "dsp/base/avx2.h"
#include "lab/pyramid/patch_quarter_body.h"
#include "lab/pyramid/patch_sums.h"

namespace stof::dsp::avx512 {
namespace {

// What patch_quarter_body.h asks for.
struct Avx512 {
  using Bytes = __m512i;
  using Sums = __m512i;
  static constexpr std::size_t kBytes = 64;

  static Bytes load_bytes(const std::uint8_t* p) noexcept { return _mm512_loadu_si512(p); }
  static void store_bytes(std::uint8_t* p, Bytes v) noexcept { avx2::store_bits(p, v); }
  static Bytes difference(Bytes a, Bytes b) noexcept {
    return _mm512_abs_epi8(_mm512_sub_epi8(a, b));  // below 128: the sign is right
  }
  static Bytes zero() noexcept { return _mm512_setzero_si512(); }
  static Bytes plus(Bytes a, Bytes b) noexcept { return _mm512_add_epi8(a, b); }
  static Bytes minus(Bytes a, Bytes b) noexcept { return _mm512_sub_epi8(a, b); }
  static Sums pairs(Bytes v) noexcept { return _mm512_maddubs_epi16(_mm512_set1_epi8(8), v); }
  static Sums firsts(Bytes v) noexcept { return _mm512_maddubs_epi16(_mm512_set1_epi16(8), v); }
  static Sums seconds(Bytes v) noexcept {
    return _mm512_maddubs_epi16(_mm512_set1_epi16(0x800), v);
  }
  template <int kBy>
  static Sums after(Sums a, Sums b) noexcept {
    if constexpr (kBy == 4) {
      return _mm512_alignr_epi64(b, a, 1);
    }
    return _mm512_alignr_epi8(_mm512_alignr_epi64(b, a, 2), a, 2 * kBy);
  }

  static Sums all(std::uint16_t v) noexcept {
    return _mm512_set1_epi16(static_cast<std::int16_t>(v));
  }
  static Sums load(const std::uint16_t* p) noexcept { return _mm512_loadu_si512(p); }
  static void store(std::uint16_t* p, Sums v) noexcept { avx2::store_bits(p, v); }
  static Sums add(Sums a, Sums b) noexcept { return _mm512_add_epi16(a, b); }
  static Sums subtract(Sums a, Sums b) noexcept { return _mm512_sub_epi16(a, b); }
  static Sums eighth(Sums v) noexcept { return _mm512_srli_epi16(v, 3); }
  static Sums low_bits(Sums v) noexcept { return _mm512_and_si512(v, all(7)); }
  static Sums smaller(Sums a, Sums b) noexcept { return _mm512_min_epu16(a, b); }
  static Sums greater(Sums a, Sums b) noexcept { return _mm512_max_epu16(a, b); }
  static Sums less(Sums a, Sums b) noexcept {
    return _mm512_movm_epi16(_mm512_cmplt_epu16_mask(a, b));
  }
  static Sums equal(Sums a, Sums b) noexcept {
    return _mm512_movm_epi16(_mm512_cmpeq_epi16_mask(a, b));
  }
  static Sums both(Sums a, Sums b) noexcept { return _mm512_and_si512(a, b); }
  static Sums either(Sums a, Sums b) noexcept { return _mm512_or_si512(a, b); }
  static Sums select(Sums mask, Sums a, Sums b) noexcept {
    return _mm512_ternarylogic_epi64(mask, a, b, 0xCA);
  }
  // Which lanes lie in begin .. end - 1.
  static Sums between(int begin, int end) noexcept {
    const __m256i bytes =
        _mm256_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20,
                         21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31);
    const Sums lane = _mm512_cvtepu8_epi16(bytes);
    const Sums from = _mm512_set1_epi16(static_cast<std::int16_t>(begin));
    const Sums to = _mm512_set1_epi16(static_cast<std::int16_t>(end));
    return _mm512_movm_epi16(
        _mm512_mask_cmplt_epi16_mask(_mm512_cmpge_epi16_mask(lane, from), lane, to));
  }
};

}  // namespace

void find_quarter(const PatchPlace& patch, Rows rows, int block_height, const PatchLimits& limits,
                  ImageView<std::int16_t> winners) noexcept {
  patch_quarter_body::find_quarter<Avx512>(patch, rows, block_height, limits, winners);
}

}  // namespace stof::dsp::avx512

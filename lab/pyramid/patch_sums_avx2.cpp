#include "lab/pyramid/patch_sums.h"

#include "dsp/base/avx2.h"
#include "lab/pyramid/patch_find_body.h"
#include "lab/pyramid/patch_quarter_body.h"
#include "lab/pyramid/patch_sums_body.h"

namespace stof::dsp::avx2 {
namespace {

constexpr i16x16 kPlaces{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

// What patch_boxes_body.h and patch_quarter_body.h ask for.
struct Avx2 {
  using Bytes = u8x32;
  using Sums = u16x16;
  static constexpr std::size_t kBytes = 32;

  static Bytes load_bytes(const std::uint8_t* p) noexcept { return avx2::load<u8x32>(p); }
  static void store_bytes(std::uint8_t* p, Bytes v) noexcept { avx2::store(p, v); }
  static Bytes difference(Bytes a, Bytes b) noexcept {
    return as<u8x32>(_mm256_abs_epi8(bits(a - b)));  // below 128: the sign is right
  }
  static Bytes zero() noexcept { return avx2::all(std::uint8_t{0}); }
  static Bytes plus(Bytes a, Bytes b) noexcept { return a + b; }
  static Bytes minus(Bytes a, Bytes b) noexcept { return a - b; }
  static Sums low(Bytes v) noexcept {
    return as<u16x16>(_mm256_cvtepu8_epi16(_mm256_castsi256_si128(bits(v))));
  }
  static Sums high(Bytes v) noexcept {
    return as<u16x16>(_mm256_cvtepu8_epi16(_mm256_extracti128_si256(bits(v), 1)));
  }
  static Sums widen(const std::uint8_t* p) noexcept {
    return as<u16x16>(
        _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));  // NOLINT: any
  }
  static Sums all(std::uint16_t v) noexcept { return avx2::all(v); }
  static Sums load(const std::uint16_t* p) noexcept { return avx2::load<u16x16>(p); }
  static void store(std::uint16_t* p, Sums v) noexcept { avx2::store(p, v); }
  static Sums add(Sums a, Sums b) noexcept { return a + b; }
  static Sums subtract(Sums a, Sums b) noexcept { return a - b; }
  static void sixteens(const std::uint8_t* p, Sums& low, Sums& high) noexcept {
    const __m256i eight = _mm256_set1_epi8(8);
    const auto pairs = [&](std::size_t x) noexcept {
      return _mm256_maddubs_epi16(eight, bits(avx2::load<u8x32>(p + x)));
    };
    const __m256i even = _mm256_add_epi16(pairs(0), pairs(8));
    const __m256i odd = _mm256_add_epi16(pairs(1), pairs(9));
    const __m256i first = _mm256_unpacklo_epi16(even, odd);  // columns 0..7 and 16..23
    const __m256i second = _mm256_unpackhi_epi16(even, odd);
    low = as<u16x16>(_mm256_permute2x128_si256(first, second, 0x20));
    high = as<u16x16>(_mm256_permute2x128_si256(first, second, 0x31));
  }
  static Sums times8(Sums v) noexcept { return v << 3; }
  static Sums eighth(Sums v) noexcept { return v >> 3; }
  static Sums low_bits(Sums v) noexcept { return v & 7; }
  static Sums smaller(Sums a, Sums b) noexcept { return avx2::smaller(a, b); }
  static Sums less(Sums a, Sums b) noexcept { return as<u16x16>(bits(a < b)); }
  static Sums equal(Sums a, Sums b) noexcept { return as<u16x16>(bits(a == b)); }
  static Sums both(Sums a, Sums b) noexcept { return a & b; }
  static Sums either(Sums a, Sums b) noexcept { return a | b; }
  static bool any(Sums mask) noexcept { return _mm256_movemask_epi8(bits(mask)) != 0; }
  static Sums select(Sums mask, Sums a, Sums b) noexcept { return (a & mask) | (b & ~mask); }
  // Which lanes lie in begin .. end - 1.
  static Sums between(int begin, int end) noexcept {
    const i16x16 from = avx2::all(static_cast<std::int16_t>(begin));
    const i16x16 to = avx2::all(static_cast<std::int16_t>(end));
    return as<u16x16>(bits((kPlaces >= from) & (kPlaces < to)));
  }

  static Sums greater(Sums a, Sums b) noexcept {
    return as<u16x16>(_mm256_max_epu16(bits(a), bits(b)));
  }
  static Sums pairs(Bytes v) noexcept {
    return as<u16x16>(_mm256_maddubs_epi16(_mm256_set1_epi8(8), bits(v)));
  }
  static Sums firsts(Bytes v) noexcept {
    return as<u16x16>(_mm256_maddubs_epi16(_mm256_set1_epi16(8), bits(v)));
  }
  static Sums seconds(Bytes v) noexcept {
    return as<u16x16>(_mm256_maddubs_epi16(_mm256_set1_epi16(0x800), bits(v)));
  }
  template <int kBy, typename V>
  static V after(V a, V b) noexcept {
    const __m256i middle = _mm256_permute2x128_si256(bits(a), bits(b), 0x21);
    return as<V>(_mm256_alignr_epi8(middle, bits(a), 2 * kBy));
  }
};

}  // namespace

void start_patch(const PatchPlace& patch, Rows rows, std::span<std::uint16_t> sums) noexcept {
  patch_sums_body::start<Avx2>(patch, rows, sums);
}
void slide_patch(const PatchPlace& patch, int entering, int leaving,
                 std::span<std::uint16_t> sums) noexcept {
  patch_sums_body::slide<Avx2>(patch, entering, leaving, sums);
}
void find_in_patch(std::span<const std::uint16_t> sums, std::span<const std::int16_t> candidates,
                   const PatchLimits& limits, std::span<std::int16_t> winners) noexcept {
  patch_sums_body::find<Avx2>(sums, candidates, limits, winners);
}
void offer_to_right(std::span<const std::uint16_t> sums, std::int16_t candidate,
                    std::span<std::uint16_t> lowest, std::span<std::int16_t> winners) noexcept {
  patch_sums_body::offer<Avx2>(sums, candidate, lowest, winners);
}
void find_quarter(const PatchPlace& patch, Rows rows, int block_height, const PatchLimits& limits,
                  ImageView<std::int16_t> winners) noexcept {
  patch_quarter_body::find_quarter<Avx2>(patch, rows, block_height, limits, winners);
}

}  // namespace stof::dsp::avx2

#include "dsp/stereo/search/numbered_right_winners.h"

#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/search/numbered_right_winners_body.h"

namespace stof::dsp::avx2 {
namespace {

struct NumberedLanes : Lanes<std::uint16_t> {
  static V either(V a, V b) noexcept { return a | b; }
  static V add(V a, V b) noexcept { return a + b; }
  static V repeated(const std::uint16_t* p) noexcept {
    return as<V>(_mm256_broadcastsi128_si256(
        _mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));  // NOLINT: any type
  }
  static V number_where_equal(V number, V a, V b) noexcept { return number | ~equal(a, b); }
  static V winners_of(V lowest, V number) noexcept {
    return (lowest & avx2::all(std::uint16_t{7})) << 3 | number;
  }
  static V better(V a, V b) noexcept { return as<V>(bits((a >> 3) < (b >> 3))); }

  template <int kSkipped>
  static V first_of(const std::uint16_t* column) noexcept {
    return load(column - kSkipped) | load(kMasks + 16 - kSkipped);
  }
  template <int kSkipped>
  static V last_of(const std::uint16_t* column) noexcept {
    return load(column + kSkipped) | load(kMasks + 16 + kSkipped);
  }
  static void store(V lowest, V winner, std::int16_t* to) noexcept {
    avx2::store(to, as<i16x16>(bits(winner | equal(lowest, avx2::all(kNoCost<std::uint16_t>)))));
  }

 private:
  // All ones, zeros and all ones, of a vector each.
  static constexpr std::uint16_t kMasks[48] = {
      0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF,
      0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0,      0,      0,      0,
      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,
      0,      0,      0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF,
      0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF};
};

}  // namespace

void numbered_right_winners(std::span<const std::uint16_t> costs, int lanes,
                            std::span<std::int16_t> winners) noexcept {
  numbered_right_winners_body::find<NumberedLanes>(costs, lanes, winners);
}

}  // namespace stof::dsp::avx2

#include "dsp/stereo/cost/census.h"

#include <array>
#include <cstddef>
#include <utility>

#include "dsp/base/simd.h"
#include "dsp/stereo/cost/census_body.h"

namespace stof::dsp::neon {
namespace {

// Compares as signed what 128 was subtracted from: the order of unsigned values, without the
// detour that x86 needs for those.
int8x16_t load_signed(const std::uint8_t* p) noexcept {
  return vreinterpretq_s8_u8(veorq_u8(vld1q_u8(p), vdupq_n_u8(128)));
}

// Sixteen descriptors. rows[r] points at the first of their columns in row r of the window and is
// read half a window beyond them on both sides; planes are `stride` apart.
template <std::size_t kWidth, std::size_t kHeight>
class Describer {
 public:
  static constexpr std::size_t kColumns = 16;
  static constexpr int kBits = kWidth * kHeight - 1;
  static constexpr std::size_t kPlanes = planes_of(kBits);

  static void describe(const std::array<const std::uint8_t*, kHeight>& rows, std::uint8_t* planes,
                       std::size_t stride) noexcept {
    const int8x16_t centre = load_signed(rows[kHeight / 2]);
    // As a fold, because compilers do not unroll loops that long, and then compute every address.
    [&]<std::size_t... kPlane>(std::index_sequence<kPlane...>) {
      (store(planes + kPlane * stride, plane<kPlane>(rows, centre, Places{})), ...);
    }(std::make_index_sequence<kPlanes>{});
  }

 private:
  // An intrinsic that is a macro does not fold.
  static void store(std::uint8_t* at, uint8x16_t bits) noexcept { vst1q_u8(at, bits); }

  using Places = std::make_index_sequence<kPlaneBits>;

  template <std::size_t kPlane, std::size_t... kPlace>
  static uint8x16_t plane(const std::array<const std::uint8_t*, kHeight>& rows, int8x16_t centre,
                          std::index_sequence<kPlace...>) noexcept {
    uint8x16_t bits = vdupq_n_u8(0);
    ((bits = shift_in<(kPlane + 1) * kPlaneBits - 1 - kPlace>(rows, centre, bits)), ...);
    return bits;
  }

  template <std::size_t kBit>
  static uint8x16_t shift_in(const std::array<const std::uint8_t*, kHeight>& rows, int8x16_t centre,
                             uint8x16_t bits) noexcept {
    if constexpr (kBit < kBits) {
      constexpr std::size_t kCell = kBit < kBits / 2 ? kBit : kBit + 1;  // steps over the centre
      const std::uint8_t* const at = rows[kCell / kWidth] + kCell % kWidth - kWidth / 2;
      const uint8x16_t darker = vcltq_s8(load_signed(at), centre);  // 0 or -1
      return vsubq_u8(vaddq_u8(bits, bits), darker);
    } else {
      return bits;
    }
  }
};

}  // namespace

void census_5x5(std::span<const std::span<const std::uint8_t>, 5> rows,
                std::span<std::uint8_t> planes) noexcept {
  census_body::census<Describer, 5, 5>(rows, planes);
}
void census_9x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  census_body::census<Describer, 9, 7>(rows, planes);
}

}  // namespace stof::dsp::neon

#include "dsp/stereo/cost/census.h"

#include <array>
#include <cstddef>
#include <utility>

#include "dsp/base/avx2.h"
#include "dsp/stereo/cost/census_body.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kColumns = 32;

// Compares as signed what 128 was subtracted from: the order of unsigned values.
i8x32 load_signed(const std::uint8_t* p) noexcept {
  return as<i8x32>(bits(load<u8x32>(p) ^ all(std::uint8_t{128})));
}

// 32 descriptors, as census_neon.cpp makes sixteen. rows[r] points at the first of their columns in
// row r of the window and is read half a window beyond them on both sides; planes are `stride`
// apart.
template <std::size_t kWidth, std::size_t kHeight>
class Describer {
 public:
  static constexpr std::size_t kColumns = avx2::kColumns;
  static constexpr int kBits = kWidth * kHeight - 1;
  static constexpr std::size_t kPlanes = planes_of(kBits);
  using Rows = std::array<const std::uint8_t*, kHeight>;

  static void describe(const Rows& rows, std::uint8_t* planes, std::size_t stride) noexcept {
    const i8x32 centre = load_signed(rows[kHeight / 2]);
    [&]<std::size_t... kPlane>(std::index_sequence<kPlane...>) {
      (store(planes + kPlane * stride,
             plane<kPlane>(rows, centre, std::make_index_sequence<kPlaneBits>{})),
       ...);
    }(std::make_index_sequence<kPlanes>{});
  }

 private:
  template <std::size_t kPlane, std::size_t... kPlace>
  static u8x32 plane(const Rows& rows, i8x32 centre,
                     std::index_sequence<kPlace...> /*places*/) noexcept {
    u8x32 places{};
    ((places = shift_in<(kPlane + 1) * kPlaneBits - 1 - kPlace>(rows, centre, places)), ...);
    return places;
  }

  template <std::size_t kBit>
  static u8x32 shift_in(const Rows& rows, i8x32 centre, u8x32 places) noexcept {
    if constexpr (kBit < kBits) {
      constexpr std::size_t kCell = kBit < kBits / 2 ? kBit : kBit + 1;  // steps over the centre
      const std::uint8_t* const at = rows[kCell / kWidth] + kCell % kWidth - kWidth / 2;
      const u8x32 darker = as<u8x32>(bits(load_signed(at) < centre));  // 0 or -1
      return places + places - darker;
    } else {
      return places;
    }
  }
};

}  // namespace

void census_5x5(std::span<const std::span<const std::uint8_t>, 5> rows,
                std::span<std::uint8_t> planes) noexcept {
  if (rows[0].size() < kColumns) {
    neon::census_5x5(rows, planes);
    return;
  }
  census_body::census<Describer, 5, 5>(rows, planes);
}
void census_9x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  if (rows[0].size() < kColumns) {
    neon::census_9x7(rows, planes);
    return;
  }
  census_body::census<Describer, 9, 7>(rows, planes);
}

}  // namespace stof::dsp::avx2

#include "dsp/stereo/cost/census.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

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

// out[k] = row[x + k - before], the nearest column where there is none.
void copy_clamped(std::span<const std::uint8_t> row, std::size_t x, std::size_t before,
                  std::span<std::uint8_t> out) noexcept {
  const std::size_t missing = before - std::min(x, before);
  const std::size_t from = x + missing - before;
  const std::size_t count = std::min(out.size() - missing, row.size() - from);
  std::ranges::fill(out.first(missing), row.front());
  std::ranges::copy(row.subspan(from, count), out.subspan(missing).begin());
  std::ranges::fill(out.subspan(missing + count), row.back());
}

// Rows of at least kColumns.
template <std::size_t kWidth, std::size_t kHeight>
void census(std::span<const std::span<const std::uint8_t>, kHeight> rows,
            std::span<std::uint8_t> planes) noexcept {
  using Columns = Describer<kWidth, kHeight>;
  constexpr std::size_t kReach = kWidth / 2;
  const std::size_t n = rows[0].size();
  for (const std::span<const std::uint8_t> row : rows) {
    STOF_CHECK(row.size() == n);
  }
  STOF_CHECK(planes.size() == Columns::kPlanes * n);
  typename Columns::Rows at;
  std::array<std::array<std::uint8_t, kColumns + 2 * kReach>, kHeight> padded;
  for (std::size_t next = 0; next < n; next += kColumns) {
    // The last vector repeats columns of the one before rather than ending outside.
    const std::size_t x = std::min(next, n - kColumns);
    const bool inside = x >= kReach && x + kColumns + kReach <= n;
    for (std::size_t r = 0; r < kHeight; ++r) {
      if (inside) {
        at[r] = rows[r].data() + x;
      } else {
        copy_clamped(rows[r], x, kReach, padded[r]);
        at[r] = padded[r].data() + kReach;
      }
    }
    Columns::describe(at, planes.data() + x, n);
  }
}

}  // namespace

void census_5x5(std::span<const std::span<const std::uint8_t>, 5> rows,
                std::span<std::uint8_t> planes) noexcept {
  if (rows[0].size() < kColumns) {
    neon::census_5x5(rows, planes);
    return;
  }
  census<5, 5>(rows, planes);
}
void census_9x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  if (rows[0].size() < kColumns) {
    neon::census_9x7(rows, planes);
    return;
  }
  census<9, 7>(rows, planes);
}

}  // namespace stof::dsp::avx2

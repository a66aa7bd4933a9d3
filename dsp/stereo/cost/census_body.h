#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/census.h"

// The vector variants of census.h; what is static here must not be shared with files for other
// processors. Isa, of an unnamed namespace: Lanes<std::uint8_t> of base/lanes_neon.h or
// lanes_avx2.h and
//   Signed, load_signed(p)   what 128 was subtracted from: signed comparisons give the order of
//                            unsigned values, without the detour that x86 needs for those
//   darker(a, b)             all ones where a < b
namespace stof::dsp::census_body {

// out[k] = row[x + k - before], the nearest column where there is none.
static void copy_clamped(std::span<const std::uint8_t> row, std::size_t x, std::size_t before,
                         std::span<std::uint8_t> out) noexcept {
  const std::size_t missing = before - std::min(x, before);
  const std::size_t from = x + missing - before;
  const std::size_t count = std::min(out.size() - missing, row.size() - from);
  std::ranges::fill(out.first(missing), row.front());
  std::ranges::copy(row.subspan(from, count), out.subspan(missing).begin());
  std::ranges::fill(out.subspan(missing + count), row.back());
}

// Descriptors of Isa::kLanes columns. rows[r] points at the first of them in row r of the window
// and is read half a window beyond them on both sides; planes are `stride` apart.
template <typename Isa, CensusWindow kWindow>
class Describer {
 public:
  static constexpr std::size_t kWidth = kWindow.width;
  static constexpr std::size_t kHeight = kWindow.height;
  static constexpr int kBits = kWindow.bits();
  static constexpr std::size_t kPlanes = planes_of(kBits);
  using Rows = std::array<const std::uint8_t*, kHeight>;

  static void describe(const Rows& rows, std::uint8_t* planes, std::size_t stride) noexcept {
    const Signed centre = Isa::load_signed(rows[kHeight / 2]);
    // As a fold, because compilers do not unroll loops that long, and then compute every address.
    [&]<std::size_t... kPlane>(std::index_sequence<kPlane...>) {
      (Isa::store(planes + kPlane * stride,
                  plane<kPlane>(rows, centre, std::make_index_sequence<kPlaneBits>{})),
       ...);
    }(std::make_index_sequence<kPlanes>{});
  }

 private:
  using V = typename Isa::V;
  using Signed = typename Isa::Signed;

  template <std::size_t kPlane, std::size_t... kPlace>
  static V plane(const Rows& rows, Signed centre, std::index_sequence<kPlace...>) noexcept {
    V bits = Isa::all(0);
    ((bits = shift_in<(kPlane + 1) * kPlaneBits - 1 - kPlace>(rows, centre, bits)), ...);
    return bits;
  }

  template <std::size_t kBit>
  static V shift_in(const Rows& rows, Signed centre, V bits) noexcept {
    if constexpr (kBit < kBits) {
      constexpr std::size_t kCell = kWindow.cell(kBit);
      const std::uint8_t* const at = rows[kCell / kWidth] + kCell % kWidth - kWidth / 2;
      return bits + bits - Isa::darker(Isa::load_signed(at), centre);  // a true mask is -1
    } else {
      return bits;
    }
  }
};

// All columns of a row.
template <typename Isa, CensusWindow kWindow>
static void census(std::span<const std::span<const std::uint8_t>, kWindow.height> rows,
                   std::span<std::uint8_t> planes) noexcept {
  using Columns = Describer<Isa, kWindow>;
  constexpr std::size_t kHeight = kWindow.height;
  constexpr std::size_t kColumns = Isa::kLanes;
  constexpr std::size_t kReach = kWindow.width / 2;
  constexpr std::size_t kPlanes = Columns::kPlanes;
  const std::size_t n = rows[0].size();
  for (const std::span<const std::uint8_t> row : rows) {
    STOF_CHECK(row.size() == n);
  }
  STOF_CHECK(planes.size() == kPlanes * n);
  std::array<const std::uint8_t*, kHeight> at;
  std::array<std::array<std::uint8_t, kColumns + 2 * kReach>, kHeight> padded;
  for (std::size_t next = 0; next < n; next += kColumns) {
    // The last vector repeats columns of the one before rather than ending outside.
    const std::size_t x = n < kColumns ? 0 : std::min(next, n - kColumns);
    const bool inside = x >= kReach && x + kColumns + kReach <= n;
    for (std::size_t r = 0; r < kHeight; ++r) {
      if (inside) {
        at[r] = rows[r].data() + x;
      } else {
        copy_clamped(rows[r], x, kReach, padded[r]);
        at[r] = padded[r].data() + kReach;
      }
    }
    if (n >= kColumns) {
      Columns::describe(at, planes.data() + x, n);
      continue;
    }
    std::array<std::uint8_t, kPlanes * kColumns> narrow;
    Columns::describe(at, narrow.data(), kColumns);
    for (std::size_t p = 0; p < kPlanes; ++p) {
      std::memcpy(planes.data() + p * n, narrow.data() + p * kColumns, n);
    }
  }
}

}  // namespace stof::dsp::census_body

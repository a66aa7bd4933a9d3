#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "dsp/base/check.h"

// The walk along a row that the vector variants of census.h share; what is static here must not be
// shared with files for other processors.
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

// All columns of a row. Describer<kWidth, kHeight> describes its kColumns at once.
template <template <std::size_t, std::size_t> typename Describer, std::size_t kWidth,
          std::size_t kHeight>
static void census(std::span<const std::span<const std::uint8_t>, kHeight> rows,
                   std::span<std::uint8_t> planes) noexcept {
  using Columns = Describer<kWidth, kHeight>;
  constexpr std::size_t kColumns = Columns::kColumns;
  constexpr std::size_t kReach = kWidth / 2;
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

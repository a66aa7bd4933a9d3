#include "dsp/stereo/cost/census.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kColumns = 16;

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

template <std::size_t kWidth, std::size_t kHeight>
void census(std::span<const std::span<const std::uint8_t>, kHeight> rows,
            std::span<std::uint8_t> planes) noexcept {
  constexpr std::size_t kReach = kWidth / 2;
  constexpr std::size_t kPlanes = Describer<kWidth, kHeight>::kPlanes;
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
      Describer<kWidth, kHeight>::describe(at, planes.data() + x, n);
      continue;
    }
    std::array<std::uint8_t, kPlanes * kColumns> narrow;
    Describer<kWidth, kHeight>::describe(at, narrow.data(), kColumns);
    for (std::size_t p = 0; p < kPlanes; ++p) {
      std::memcpy(planes.data() + p * n, narrow.data() + p * kColumns, n);
    }
  }
}

}  // namespace

void census_5x5(std::span<const std::span<const std::uint8_t>, 5> rows,
                std::span<std::uint8_t> planes) noexcept {
  census<5, 5>(rows, planes);
}
void census_9x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  census<9, 7>(rows, planes);
}

}  // namespace stof::dsp::neon

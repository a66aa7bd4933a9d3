#include "dsp/stereo/cost/cross_aggregation.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kStep = 16;

u16x16 widen(const std::uint8_t* costs) noexcept {
  const auto* const at = reinterpret_cast<const __m128i*>(costs);  // NOLINT: any type
  return as<u16x16>(_mm256_cvtepu8_epi16(_mm_loadu_si128(at)));
}

// Sixteen means that are not clipped yet; reciprocal is not negative, so nothing saturates.
__m256i mean(const std::uint16_t* above, const std::uint16_t* below, __m256i reciprocal) noexcept {
  const u16x16 sum = load<u16x16>(below) - load<u16x16>(above);
  return _mm256_mulhrs_epi16(_mm256_srli_epi16(bits(sum), 1), reciprocal);
}

// kVectors * kStep candidates from `group` on, which stay in registers all along the row.
template <std::size_t kVectors>
void sum_group(std::span<const std::uint8_t> costs, std::size_t step, std::size_t group,
               std::uint16_t* sums) noexcept {
  u16x16 totals[kVectors] = {};
  for (std::size_t i = group; i < costs.size(); i += step) {
    std::uint16_t* const to = sums + i + step;
    for (std::size_t v = 0; v < kVectors; ++v) {
      totals[v] += widen(costs.data() + i + v * kStep);
      store(to + v * kStep, totals[v]);
    }
  }
}

}  // namespace

void sum_along(std::span<const std::uint8_t> costs, int lanes,
               std::span<std::uint16_t> sums) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % 16 == 0 && sums.size() == costs.size() + step);
  for (std::size_t i = 0; i < step; i += kStep) {
    store(sums.data() + i, u16x16{});
  }
  std::size_t group = 0;
  for (; group + 4 * kStep <= step; group += 4 * kStep) {
    sum_group<4>(costs, step, group, sums.data());
  }
  for (; group < step; group += kStep) {
    sum_group<1>(costs, step, group, sums.data());
  }
}

void sum_down(std::span<const std::uint16_t> sums, std::span<const std::uint8_t> left,
              std::span<const std::uint8_t> right, int lanes, std::span<const std::uint16_t> above,
              std::span<std::uint16_t> below) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % 16 == 0 && right.size() == left.size() &&
             sums.size() == (left.size() + 1) * step && above.size() == left.size() * step &&
             below.size() == above.size());
  for (std::size_t x = 0; x < left.size(); ++x) {
    const std::uint16_t* const begin = sums.data() + (x - left[x]) * step;
    const std::uint16_t* const end = sums.data() + (x + right[x] + 1) * step;
    const std::uint16_t* const from = above.data() + x * step;
    std::uint16_t* const to = below.data() + x * step;
    for (std::size_t i = 0; i < step; i += kStep) {
      store(to + i, load<u16x16>(from + i) + (load<u16x16>(end + i) - load<u16x16>(begin + i)));
    }
  }
}

void cross_means(std::span<const CrossEnds> ends, int lanes,
                 std::span<std::uint8_t> means) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  if (lanes % 32 != 0) {
    neon::cross_means(ends, lanes, means);
    return;
  }
  STOF_CHECK(means.size() == ends.size() * step);
  for (std::size_t x = 0; x < ends.size(); ++x) {
    const std::uint16_t* const above = ends[x].above + x * step;
    const std::uint16_t* const below = ends[x].below + x * step;
    const __m256i reciprocal = _mm256_set1_epi16(ends[x].reciprocal);
    std::uint8_t* const to = means.data() + x * step;
    for (std::size_t i = 0; i < step; i += 2 * kStep) {
      const __m256i low = mean(above + i, below + i, reciprocal);
      const __m256i high = mean(above + i + kStep, below + i + kStep, reciprocal);
      // Packs each half by itself.
      const __m256i packed = _mm256_packus_epi16(low, high);
      store(to + i, as<u8x32>(_mm256_permute4x64_epi64(packed, 0b11'01'10'00)));
    }
  }
}

}  // namespace stof::dsp::avx2

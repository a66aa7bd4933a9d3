#include "dsp/stereo/cost/census.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

template <CensusWindow kWindow>
void census(std::span<const std::span<const std::uint8_t>, kWindow.height> rows,
            std::span<std::uint8_t> planes) noexcept {
  constexpr std::size_t kWidth = kWindow.width;
  constexpr std::size_t kHeight = kWindow.height;
  const std::size_t n = rows[kHeight / 2].size();
  for (const std::span<const std::uint8_t> row : rows) {
    STOF_CHECK(row.size() == n);
  }
  STOF_CHECK(planes.size() == planes_of(kWindow.bits()) * n);
  std::ranges::fill(planes, std::uint8_t{0});
  for (std::size_t x = 0; x < n; ++x) {
    const std::uint8_t centre = rows[kHeight / 2][x];
    for (std::size_t bit = 0; bit < static_cast<std::size_t>(kWindow.bits()); ++bit) {
      const std::size_t cell = kWindow.cell(bit);
      const std::size_t shifted = x + cell % kWidth;  // half a window to the right
      const std::size_t column = std::min(std::max(shifted, kWidth / 2) - kWidth / 2, n - 1);
      const int darker = rows[cell / kWidth][column] < centre ? 1 : 0;
      std::uint8_t& byte = planes[bit / kPlaneBits * n + x];
      byte = static_cast<std::uint8_t>(byte | darker << (bit % kPlaneBits));
    }
  }
}

}  // namespace

void census_5x5(std::span<const std::span<const std::uint8_t>, 5> rows,
                std::span<std::uint8_t> planes) noexcept {
  census<kCensus5x5>(rows, planes);
}
void census_7x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  census<kCensus7x7>(rows, planes);
}
void census_9x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  census<kCensus9x7>(rows, planes);
}

}  // namespace stof::dsp::ref

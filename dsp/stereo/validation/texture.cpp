#include "dsp/stereo/validation/texture.h"

#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/stereo/validation/window_sums.h"

namespace stof::dsp {

void drop_flat(ImageView<const std::uint8_t> derivative, int cap, int min_texture, Rows rows,
               WindowSums& window, ImageView<Disparity> disparities) noexcept {
  STOF_CHECK(same_size(derivative, disparities) && cap >= 1 && cap <= 127 && min_texture >= 0 &&
             rows.begin >= 0 && rows.end <= derivative.height());
  if (derivative.empty()) {
    return;
  }
  window.start(derivative.width());
  const std::span<std::int16_t> sizes = window.values();
  const std::int64_t least = std::int64_t{min_texture} * WindowSums::kArea;
  for_each_window_row(
      derivative.height(), rows, window,
      [&](int y) noexcept -> std::span<const std::int16_t> {
        const std::span<const std::uint8_t> row = derivative.row(y);
        for (std::size_t x = 0; x < row.size(); ++x) {
          sizes[x] = static_cast<std::int16_t>(std::abs(row[x] - cap));
        }
        return sizes;
      },
      [&](int y, std::span<const std::int32_t> sums) noexcept {
        const std::span<Disparity> out = disparities.row(y);
        for (std::size_t x = 0; x < sums.size(); ++x) {
          out[x] = sums[x] < least ? Disparity::none() : out[x];
        }
      });
}

}  // namespace stof::dsp

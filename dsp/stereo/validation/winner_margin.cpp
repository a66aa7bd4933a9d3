#include "dsp/stereo/validation/winner_margin.h"

#include "dsp/base/check.h"
#include "dsp/stereo/validation/window_sums.h"

namespace stof::dsp {

void drop_small_margins(ImageView<const std::int16_t> margins, Rows rows, WindowSums& window,
                        ImageView<Disparity> disparities) noexcept {
  STOF_CHECK(same_size(margins, disparities) && rows.begin >= 0 && rows.end <= margins.height());
  if (margins.empty()) {
    return;
  }
  window.start(margins.width());
  for_each_window_row(
      margins.height(), rows, window, [&](int y) noexcept { return margins.row(y); },
      [&](int y, std::span<const std::int32_t> sums) noexcept {
        const std::span<Disparity> out = disparities.row(y);
        for (std::size_t x = 0; x < sums.size(); ++x) {
          out[x] = sums[x] <= 0 ? Disparity::none() : out[x];
        }
      });
}

}  // namespace stof::dsp

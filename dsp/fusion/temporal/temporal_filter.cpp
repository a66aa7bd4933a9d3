#include "dsp/fusion/temporal/temporal_filter.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

constexpr int kHeldRows = 3;  // above, here, below
constexpr int kUnchanged = kHeldRows;

template <typename T>
void clear(const ImageView<T>& image) noexcept {
  for (int y = 0; y < image.height(); ++y) {
    std::ranges::fill(image.row(y), T{0});
  }
}

}  // namespace

TemporalFilter::TemporalFilter(int width, int height, const TemporalParams& params,
                               Arena& arena) noexcept
    : params_(params),
      mean_(arena.take_image<QuarterMm>(width, height)),
      scatter_(arena.take_image<std::uint16_t>(width, height)),
      tally_(arena.take_image<std::uint8_t>(width, height)),
      kind_(arena.take_image<std::uint8_t>(width, height)),
      grey_(arena.take_image<std::uint8_t>(width, height)),
      change_(arena.take_image<std::uint8_t>(width + 2, kHeldRows + 1)) {
  STOF_CHECK(params.frames >= 1 && params.frames <= kMostFrames && params.max_step <= kMostStep);
  if (!arena.is_measuring()) {
    clear(change_);
    clear(grey_);
    forget();
  }
}

void TemporalFilter::forget() noexcept {
  clear(mean_);
  clear(scatter_);
  clear(tally_);
  clear(kind_);
}

// Must be asked for before the row's state is written. Holds until row y + 3.
std::span<const std::uint8_t> TemporalFilter::change_in(ImageView<const std::uint8_t> left, int y,
                                                        const PictureChange* change) noexcept {
  if (y >= left.height()) {
    return change_.row(kUnchanged);
  }
  const std::span<std::uint8_t> row = change_.row(y % kHeldRows);
  const std::span<std::uint8_t> pixels = row.subspan(1, row.size() - 2);
  best::grey_change(left.row(y), grey_.row(y), pixels);
  if (change != nullptr) {
    change->add_to(y, pixels);
  }
  return row;
}

void TemporalFilter::apply(ImageView<const std::uint8_t> left, const DepthMap& map,
                           const PictureChange* change) noexcept {
  STOF_CHECK(same_size(map.depth, mean_) && same_size(map.width, mean_) &&
             same_size(map.source, mean_));
  if (left.empty()) {
    forget();
    return;
  }
  STOF_CHECK(same_size(left, mean_));
  ChangeRows rows{
      .above = change_.row(kUnchanged), .here = change_in(left, 0, change), .below = {}};
  for (int y = 0; y < left.height(); ++y) {
    rows.below = change_in(left, y + 1, change);
    best::temporal_row({.grey = left.row(y),
                        .change = rows,
                        .source = map.source.row(y),
                        .depth = map.depth.row(y),
                        .width = map.width.row(y)},
                       params_,
                       {.mean = mean_.row(y),
                        .scatter = scatter_.row(y),
                        .tally = tally_.row(y),
                        .kind = kind_.row(y),
                        .grey = grey_.row(y)});
    rows.above = rows.here;
    rows.here = rows.below;
  }
}

}  // namespace stof::dsp

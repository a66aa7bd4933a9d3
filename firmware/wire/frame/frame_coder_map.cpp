#include <algorithm>

#include "dsp/base/check.h"
#include "firmware/wire/codec/interval_quantiser.h"
#include "firmware/wire/frame/frame_coder.h"

// Depth, width and source of a frame; the first two belong together where they are rounded.
namespace stof::wire {
namespace {

constexpr int kCauseShift = 4;  // source and cause share a byte

}  // namespace

// Rows of one scale are one raster: no tile has two. As many tiles as raw ones at most, or they are
// raw and not scaled, with the same values.
void FrameCoder::add_scaled_tiles(std::span<std::uint16_t> values, const Raster& raster) noexcept {
  bool& is_raw = is_raw_[static_cast<std::size_t>(raster.stream) - 1];
  const std::size_t begin = store_.size();
  const std::size_t most = raw_tiles(raster.width, raster.height, sizeof(std::uint16_t));
  const std::size_t bands = fit_bands(static_cast<int>(raster.height));
  for (std::size_t band = 0; band < bands;) {
    const std::uint8_t scale = scales_[band];
    std::size_t next = band + 1;
    while (next < bands && scales_[next] == scale) {
      ++next;
    }
    const std::size_t first = band * kFitRows;
    const std::size_t rows = std::min(next * kFitRows, raster.height) - first;
    const Raster part{.stream = raster.stream,
                      .width = raster.width,
                      .height = rows,
                      .first_row = first,
                      .image_height = raster.height,
                      .scale = scale};
    const std::size_t left = most - (store_.size() - begin);
    is_raw = is_raw ||
             !try_rvl_tiles<std::uint16_t>(
                 values.subspan(first * raster.width, rows * raster.width), part, left, store_);
    if (is_raw) {
      store_.cut_back(begin);
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t row = i / raster.width;
        values[i] = static_cast<std::uint16_t>(values[i] << scales_[row / kFitRows]);
      }
      add_raw_tiles<std::uint16_t>(values, raster, store_);
      return;
    }
    band = next;
  }
}

std::span<std::uint16_t> FrameCoder::rounded(const dsp::DepthMap& map,
                                             const Rounding& rounding) noexcept {
  const auto columns = static_cast<std::size_t>(map.depth.width());
  const std::span<std::uint16_t> values =
      values16_.first(columns * static_cast<std::size_t>(map.depth.height()));
  for (int y = 0; y < map.depth.height(); ++y) {
    const unsigned scale = scales_[static_cast<std::size_t>(y / kFitRows)];
    const std::span<std::uint16_t> out =
        values.subspan(static_cast<std::size_t>(y) * columns, columns);
    if (rounding.stream == Stream::kDepth) {
      fit_depth(map.depth.row(y), scale, out);
      continue;
    }
    grow_width(map.depth.row(y), map.width.row(y), rounding.depth ? scale : 0, out);
    if (rounding.scaled) {
      fit_width(out, scale);
    }
  }
  return values;
}

void FrameCoder::add_source(const dsp::DepthMap& map, Coding coding) noexcept {
  if (coding == Coding::kOff || map.source.empty()) {
    return;
  }
  STOF_CHECK(map.cause.empty() || same_size(map.cause, map.source));
  const int width = map.source.width();
  const auto columns = static_cast<std::size_t>(width);
  const std::span<std::uint8_t> values =
      values8_.first(columns * static_cast<std::size_t>(map.source.height()));
  for (int y = 0; y < map.source.height(); ++y) {
    const std::span<std::uint8_t> out =
        values.subspan(static_cast<std::size_t>(y) * columns, columns);
    std::ranges::transform(map.source.row(y), out.begin(),
                           [](dsp::Source source) { return static_cast<std::uint8_t>(source); });
    if (!map.cause.empty()) {
      std::ranges::transform(out, map.cause.row(y), out.begin(),
                             [](std::uint8_t source, dsp::Cause cause) {
                               const int bits = static_cast<int>(cause) << kCauseShift;
                               return static_cast<std::uint8_t>(source | bits);
                             });
    }
  }
  if (coding == Coding::kRaw ||
      !add_steps(values, {.stream = Stream::kSource,
                          .width = columns,
                          .height = static_cast<std::size_t>(map.source.height())})) {
    add_tiles<std::uint8_t>(values, Stream::kSource, width, map.source.height(), coding);
  }
}

// Neighbours are mostly alike: steps from one to the next are mostly zeros, which RVL counts.
// false: a row does not fit a tile, where the first pixel of a tile would be told as a step. Then
// nothing is added and the values are as they were.
bool FrameCoder::add_steps(std::span<std::uint8_t> values, Raster raster) noexcept {
  if (no_steps_) {
    return false;
  }
  for (std::size_t first = 0; first < values.size(); first += raster.width) {
    for (std::size_t x = raster.width - 1; x > 0; --x) {
      values[first + x] ^= values[first + x - 1];
    }
  }
  raster.steps = true;
  const std::size_t begin = store_.size();
  add_values<std::uint8_t>(values, raster, Coding::kRvl);
  bool whole = true;
  for (std::size_t i = begin; i < store_.size(); ++i) {
    whole = whole && store_.part(i).first_column == 0;
  }
  if (whole) {
    return true;
  }
  store_.cut_back(begin);
  no_steps_ = true;
  is_raw_[static_cast<std::size_t>(raster.stream) - 1] = false;  // that was told of the steps
  for (std::size_t first = 0; first < values.size(); first += raster.width) {
    for (std::size_t x = 1; x < raster.width; ++x) {
      values[first + x] ^= values[first + x - 1];
    }
  }
  return false;
}

void FrameCoder::add_depth_and_width(const dsp::DepthMap& map,
                                     const StreamChoice& choice) noexcept {
  const Coding depth = choice.of(Stream::kDepth);
  const Coding width = choice.of(Stream::kWidth);
  const bool fit = depth == Coding::kFit || width == Coding::kFit;
  if (!fit || map.depth.empty() || map.width.empty()) {
    add_image<dsp::QuarterMm>(map.depth, Stream::kDepth, depth);
    add_image<dsp::QuarterMm>(map.width, Stream::kWidth, width);
    return;
  }
  STOF_CHECK(same_size(map.depth, map.width));
  const Raster raster{.stream = Stream::kDepth,
                      .width = static_cast<std::size_t>(map.depth.width()),
                      .height = static_cast<std::size_t>(map.depth.height())};
  for (std::size_t band = 0; band < fit_bands(map.depth.height()); ++band) {
    scales_[band] = fit_scale(map, static_cast<int>(band) * kFitRows);
  }
  if (depth == Coding::kFit) {
    add_scaled_tiles(rounded(map, {.stream = Stream::kDepth}), raster);
  } else {
    add_image<dsp::QuarterMm>(map.depth, Stream::kDepth, depth);
  }
  Raster widths = raster;
  widths.stream = Stream::kWidth;
  const Rounding rounding{
      .stream = Stream::kWidth, .depth = depth == Coding::kFit, .scaled = width == Coding::kFit};
  if (rounding.scaled) {
    add_scaled_tiles(rounded(map, rounding), widths);
  } else if (width != Coding::kOff) {
    add_tiles<std::uint16_t>(rounded(map, rounding), Stream::kWidth, map.width.width(),
                             map.width.height(), width);
  }
}

void FrameCoder::add_map(const dsp::DepthMap& map, const StreamChoice& choice) noexcept {
  add_depth_and_width(map, choice);
  add_source(map, choice.of(Stream::kSource));
}

}  // namespace stof::wire

#include "firmware/wire/frame/image_coder.h"

#include <algorithm>
#include <type_traits>

#include "dsp/base/check.h"
#include "firmware/wire/codec/interval_quantiser.h"

namespace stof::wire {
namespace {

constexpr int kDisparityOffset = 32'768;
constexpr int kCauseShift = 4;  // source and cause share a byte

constexpr std::size_t pixels16(const FrameSizes& sizes) noexcept {
  return std::max(static_cast<std::size_t>(sizes.width) * static_cast<std::size_t>(sizes.height),
                  kPmdSamples * static_cast<std::size_t>(sizes.pmd_width) *
                      static_cast<std::size_t>(sizes.pmd_height));
}

template <typename T>
void copy_image(dsp::ImageView<const T> image, std::span<T> out) noexcept {
  for (int y = 0; y < image.height(); ++y) {
    std::ranges::copy(image.row(y), out.begin());
    out = out.subspan(image.row(y).size());
  }
}

Raster raster_of(Stream stream, int width, int height) noexcept {
  return {.stream = stream,
          .width = static_cast<std::size_t>(width),
          .height = static_cast<std::size_t>(height)};
}

}  // namespace

ImageCoder::ImageCoder(const FrameSizes& sizes, dsp::Arena& arena) noexcept
    : values16_(arena.take<std::uint16_t>(pixels16(sizes))),
      values8_(reinterpret_cast<std::uint8_t*>(values16_.data()),  // NOLINT: one at a time
               values16_.size_bytes()),
      scales_(arena.take<std::uint8_t>(quantiser_bands(sizes.height))) {}

void ImageCoder::begin_frame() noexcept {
  is_raw_ = {};
  no_xor_deltas_ = false;
}

template <typename T>
std::span<T> ImageCoder::room(std::size_t count) noexcept {
  if constexpr (std::is_same_v<T, std::uint8_t>) {
    return values8_.first(count);
  } else {
    return values16_.first(count);
  }
}

template <typename T>
void ImageCoder::add_values(std::span<const T> values, const Raster& raster, Coding coding,
                            PartStore& store) noexcept {
  bool& raw = is_raw(raster.stream);
  if (coding == Coding::kRaw || raw) {
    add_raw_tiles(values, raster, store);
  } else {
    raw = !add_rvl_tiles(values, raster, store);
  }
}

template <typename T>
void ImageCoder::add_image(dsp::ImageView<const T> image, Stream stream, Coding coding,
                           PartStore& store) noexcept {
  if (coding == Coding::kOff || image.empty()) {
    return;
  }
  const std::size_t count =
      static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.height());
  const Raster raster = raster_of(stream, image.width(), image.height());
  if (image.stride() == image.width()) {
    add_values(std::span<const T>(image.data(), count), raster, coding, store);
    return;
  }
  const std::span<T> values = room<T>(count);
  copy_image(image, values);
  add_values<T>(values, raster, coding, store);
}

void ImageCoder::add_disparity(dsp::ImageView<const dsp::Disparity> image, Coding coding,
                               PartStore& store) noexcept {
  if (coding == Coding::kOff || image.empty()) {
    return;
  }
  const auto columns = static_cast<std::size_t>(image.width());
  const std::span<std::uint16_t> values =
      values16_.first(columns * static_cast<std::size_t>(image.height()));
  for (int y = 0; y < image.height(); ++y) {
    const std::span<std::uint16_t> out =
        values.subspan(static_cast<std::size_t>(y) * columns, columns);
    std::ranges::transform(image.row(y), out.begin(), [](dsp::Disparity disparity) {
      return static_cast<std::uint16_t>(disparity.raw + kDisparityOffset);  // none becomes 0
    });
  }
  add_values<std::uint16_t>(values, raster_of(Stream::kDisparity, image.width(), image.height()),
                            coding, store);
}

void ImageCoder::add_pmd(const FrameImages& images, Coding coding, PartStore& store) noexcept {
  const dsp::ImageView<const std::uint16_t>& first = images.pmd.front();
  if (coding == Coding::kOff || first.empty()) {
    return;
  }
  const std::size_t count =
      static_cast<std::size_t>(first.width()) * static_cast<std::size_t>(first.height());
  const std::span<std::uint16_t> values = values16_.first(kPmdSamples * count);
  for (std::size_t k = 0; k < kPmdSamples; ++k) {
    STOF_CHECK(same_size(images.pmd[k], first));
    copy_image(images.pmd[k], values.subspan(k * count, count));
  }
  const int height = static_cast<int>(kPmdSamples) * first.height();
  add_values<std::uint16_t>(values, raster_of(Stream::kPmdRaw, first.width(), height), coding,
                            store);
}

// Rows of one scale are one raster: no tile has two. As many tiles as raw ones at most, or they are
// raw and not scaled, with the same values.
void ImageCoder::add_scaled_tiles(std::span<std::uint16_t> values, const Raster& raster,
                                  PartStore& store) noexcept {
  bool& raw = is_raw(raster.stream);
  const std::size_t begin = store.size();
  const std::size_t most = raw_tiles(raster.width, raster.height, sizeof(std::uint16_t));
  const std::size_t bands = quantiser_bands(static_cast<int>(raster.height));
  for (std::size_t band = 0; band < bands;) {
    const std::uint8_t scale = scales_[band];
    std::size_t next = band + 1;
    while (next < bands && scales_[next] == scale) {
      ++next;
    }
    const std::size_t first = band * kQuantiserRows;
    const std::size_t rows = std::min(next * kQuantiserRows, raster.height) - first;
    const Raster part{.stream = raster.stream,
                      .width = raster.width,
                      .height = rows,
                      .first_row = first,
                      .image_height = raster.height,
                      .scale = scale};
    const std::size_t left = most - (store.size() - begin);
    raw = raw || !try_rvl_tiles<std::uint16_t>(
                     values.subspan(first * raster.width, rows * raster.width), part, left, store);
    if (raw) {
      store.cut_back(begin);
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t row = i / raster.width;
        values[i] = static_cast<std::uint16_t>(values[i] << scales_[row / kQuantiserRows]);
      }
      add_raw_tiles<std::uint16_t>(values, raster, store);
      return;
    }
    band = next;
  }
}

std::span<std::uint16_t> ImageCoder::rounded(const dsp::DepthMap& map,
                                             const Rounding& rounding) noexcept {
  const auto columns = static_cast<std::size_t>(map.depth.width());
  const std::span<std::uint16_t> values =
      values16_.first(columns * static_cast<std::size_t>(map.depth.height()));
  for (int y = 0; y < map.depth.height(); ++y) {
    const unsigned scale = scales_[static_cast<std::size_t>(y / kQuantiserRows)];
    const std::span<std::uint16_t> out =
        values.subspan(static_cast<std::size_t>(y) * columns, columns);
    if (rounding.stream == Stream::kDepth) {
      quantise_depth(map.depth.row(y), scale, out);
      continue;
    }
    grow_width(map.depth.row(y), map.width.row(y), rounding.depth ? scale : 0, out);
    if (rounding.scaled) {
      quantise_width(out, scale);
    }
  }
  return values;
}

void ImageCoder::add_source(const dsp::DepthMap& map, Coding coding, PartStore& store) noexcept {
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
  const Raster raster = raster_of(Stream::kSource, width, map.source.height());
  if (coding == Coding::kRaw || !add_xor_deltas(values, raster, store)) {
    add_values<std::uint8_t>(values, raster, coding, store);
  }
}

// Neighbours are mostly alike: their exclusive ors are mostly zeros, which RVL counts. false: a row
// does not fit a tile, so that a tile would begin inside of a row. Then nothing is added and the
// values are as they were.
bool ImageCoder::add_xor_deltas(std::span<std::uint8_t> values, Raster raster,
                                PartStore& store) noexcept {
  if (no_xor_deltas_) {
    return false;
  }
  for (std::size_t first = 0; first < values.size(); first += raster.width) {
    for (std::size_t x = raster.width - 1; x > 0; --x) {
      values[first + x] ^= values[first + x - 1];
    }
  }
  raster.xor_delta = true;
  const std::size_t begin = store.size();
  add_values<std::uint8_t>(values, raster, Coding::kRvl, store);
  bool whole = true;
  for (std::size_t i = begin; i < store.size(); ++i) {
    whole = whole && store.part(i).first_column == 0;
  }
  if (whole) {
    return true;
  }
  store.cut_back(begin);
  no_xor_deltas_ = true;
  is_raw(raster.stream) = false;  // what add_values() set was of the exclusive ors
  for (std::size_t first = 0; first < values.size(); first += raster.width) {
    for (std::size_t x = 1; x < raster.width; ++x) {
      values[first + x] ^= values[first + x - 1];
    }
  }
  return false;
}

void ImageCoder::add_depth_and_width(const dsp::DepthMap& map, const StreamChoice& choice,
                                     PartStore& store) noexcept {
  const Coding depth = choice.of(Stream::kDepth);
  const Coding width = choice.of(Stream::kWidth);
  const bool quantised = depth == Coding::kQuantised || width == Coding::kQuantised;
  if (!quantised || map.depth.empty() || map.width.empty()) {
    add_image<dsp::QuarterMm>(map.depth, Stream::kDepth, depth, store);
    add_image<dsp::QuarterMm>(map.width, Stream::kWidth, width, store);
    return;
  }
  STOF_CHECK(same_size(map.depth, map.width));
  const Raster raster = raster_of(Stream::kDepth, map.depth.width(), map.depth.height());
  for (std::size_t band = 0; band < quantiser_bands(map.depth.height()); ++band) {
    scales_[band] = quantiser_scale(map, static_cast<int>(band) * kQuantiserRows);
  }
  if (depth == Coding::kQuantised) {
    add_scaled_tiles(rounded(map, {.stream = Stream::kDepth}), raster, store);
  } else {
    add_image<dsp::QuarterMm>(map.depth, Stream::kDepth, depth, store);
  }
  Raster widths = raster;
  widths.stream = Stream::kWidth;
  const Rounding rounding{.stream = Stream::kWidth,
                          .depth = depth == Coding::kQuantised,
                          .scaled = width == Coding::kQuantised};
  if (rounding.scaled) {
    add_scaled_tiles(rounded(map, rounding), widths, store);
  } else if (width != Coding::kOff) {
    add_values<std::uint16_t>(rounded(map, rounding), widths, width, store);
  }
}

void ImageCoder::add_map(const dsp::DepthMap& map, const StreamChoice& choice,
                         PartStore& store) noexcept {
  add_depth_and_width(map, choice, store);
  add_source(map, choice.of(Stream::kSource), store);
}

void ImageCoder::add_grey(dsp::ImageView<const std::uint8_t> image, Stream stream, Coding coding,
                          PartStore& store) noexcept {
  add_image(image, stream, coding, store);
}

}  // namespace stof::wire

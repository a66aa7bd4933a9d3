#include <algorithm>

#include "dsp/base/target.h"
#include "dsp/stereo/check/distinct.h"
#include "dsp/stereo/check/histogram.h"
#include "dsp/stereo/check/speckle.h"
#include "dsp/stereo/check/texture.h"
#include "dsp/stereo/map_search.h"
#include "dsp/stereo/matcher.h"
#include "dsp/stereo/refine/fill.h"
#include "dsp/stereo/refine/median.h"

// The part of a Matcher that looks at the whole map.
namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

}  // namespace

// Drops what the whole map speaks against.
void Matcher::drop_implausible(ImageView<Disparity> out) noexcept {
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  for (int y = 0; !weak_.empty() && y < height_; ++y) {
    std::ranges::copy(out.row(y), before.row(y).begin());
  }
  if (params_.min_texture) {
    drop_flat(pair_.left(), *params_.prefilter_cap, *params_.min_texture, out.rows(),
              Arena(scratch_), out);
  }
  if (params_.distinct) {
    drop_indistinct(cut(margins_, width_, height_), out.rows(), Arena(scratch_), out);
  }
  if (params_.histogram_permille) {
    Arena arena(scratch_);
    drop_rare(out, params_.min_disparity, *params_.histogram_permille,
              arena.take<std::uint32_t>(size(params_.disparities) + 1));
  }
  if (params_.speckle_pixels) {
    drop_speckles(out, *params_.speckle_pixels, Arena(scratch_));
  }
  keep_weak(out);
}

// Of what was consistent, what was dropped since.
void Matcher::keep_weak(ImageView<const Disparity> out) noexcept {
  const ImageView<Disparity> weak = cut(weak_, width_, height_);
  if (weak.empty()) {
    return;
  }
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  if (params_.speckle_pixels) {
    drop_speckles(before, *params_.speckle_pixels, Arena(scratch_));
  }
  for (int y = 0; y < height_; ++y) {
    for (std::size_t x = 0; x < size(width_); ++x) {
      weak.row(y)[x] = out.row(y)[x].valid() ? Disparity::none() : before.row(y)[x];
    }
  }
}

void Matcher::finish(ImageView<Disparity> out) noexcept {
  if (out.empty()) {
    return;
  }
  if (searches_map(params_)) {
    match_map(out);
  }
  drop_implausible(out);
  if (params_.median) {
    const ImageView<Disparity> copy = cut(spare_, width_, height_);
    for (int y = 0; y < height_; ++y) {
      std::ranges::copy(out.row(y), copy.row(y).begin());
    }
    best::median_disparity(copy, out.rows(), out);
  }
  if (params_.fill) {
    fill_from_background(out, out.rows(), cut(filled_, width_, height_));
  }
  for (int y = 0; !filled_.empty() && y < height_; ++y) {
    const std::span<std::uint8_t> filled = filled_.row(y);
    for (std::size_t x = 0; x < size(width_); ++x) {
      filled[x] = out.row(y)[x].valid() ? filled[x] : std::uint8_t{0};  // a check dropped it
    }
  }
}

}  // namespace stof::dsp

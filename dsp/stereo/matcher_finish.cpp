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

void copy_rows(ImageView<const Disparity> from, Rows rows, ImageView<Disparity> to) noexcept {
  for (int y = rows.begin; y < rows.end; ++y) {
    std::ranges::copy(from.row(y), to.row(y).begin());
  }
}

// What was there before, and is not any more.
void keep_dropped(std::span<const Disparity> before, std::span<const Disparity> now,
                  std::span<Disparity> dropped) noexcept {
  for (std::size_t x = 0; x < dropped.size(); ++x) {
    dropped[x] = now[x].valid() ? Disparity::none() : before[x];
  }
}

}  // namespace

// Drops what the whole map speaks against.
void Matcher::drop_implausible(ImageView<Disparity> out) noexcept {
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  const ImageView<const std::int16_t> margins = cut(margins_, width_, height_);
  if (!weak_.empty() || params_.min_texture || params_.distinct) {
    // Few large stripes: each begins its sums over 24 rows anew.
    const int stripes = crew_.threads() == 1 ? 1 : 2 * crew_.threads();
    const int step = (height_ + stripes - 1) / stripes;
    crew_.run_rows(out.rows(), step, [&](Rows rows, int thread) noexcept {
      if (!weak_.empty()) {
        copy_rows(out, rows, before);
      }
      if (params_.min_texture) {
        drop_flat(pair_.left(), *params_.prefilter_cap, *params_.min_texture, rows,
                  Arena(scratch_of(thread)), out);
      }
      if (params_.distinct) {
        drop_indistinct(margins, rows, Arena(scratch_of(thread)), out);
      }
    });
  }
  if (params_.histogram_permille) {
    Arena arena(scratch_);
    drop_rare(out, params_.min_disparity, *params_.histogram_permille,
              arena.take<std::uint32_t>(size(params_.disparities) + 1));
  }
  if (params_.speckle_pixels) {
    drop_specks(out);
  }
  keep_weak(out);
}

// Of the map, and of what was there before its checks.
void Matcher::drop_specks(ImageView<Disparity> out) noexcept {
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  crew_.run(weak_.empty() ? 1 : 2, [&](int part, int) noexcept {
    drop_speckles(part == 0 ? out : before, *params_.speckle_pixels,
                  Arena(scratch_.subspan(size(part) * map_bytes_)));
  });
}

// Of what was consistent, what was dropped since.
void Matcher::keep_weak(ImageView<const Disparity> out) noexcept {
  const ImageView<Disparity> weak = cut(weak_, width_, height_);
  if (weak.empty()) {
    return;
  }
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  by_rows([&](Rows rows, int) noexcept {
    for (int y = rows.begin; y < rows.end; ++y) {
      keep_dropped(before.row(y), out.row(y), weak.row(y));
    }
  });
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
    by_rows([&](Rows rows, int) noexcept { copy_rows(out, rows, copy); });
    by_rows([&](Rows rows, int) noexcept { best::median_disparity(copy, rows, out); });
  }
  note_filled(out);
}

void Matcher::note_filled(ImageView<Disparity> out) noexcept {
  if (filled_.empty()) {
    return;
  }
  by_rows([&](Rows rows, int) noexcept {
    if (params_.fill) {
      fill_from_background(out, rows, cut(filled_, width_, height_));
    }
    for (int y = rows.begin; y < rows.end; ++y) {
      const std::span<std::uint8_t> filled = filled_.row(y);
      for (std::size_t x = 0; x < size(width_); ++x) {
        filled[x] = out.row(y)[x].valid() ? filled[x] : std::uint8_t{0};  // a check dropped it
      }
    }
  });
}

}  // namespace stof::dsp

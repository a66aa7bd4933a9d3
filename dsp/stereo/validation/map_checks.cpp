#include "dsp/stereo/validation/map_checks.h"

#include <algorithm>

#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/refine/median.h"
#include "dsp/stereo/validation/histogram.h"
#include "dsp/stereo/validation/texture.h"
#include "dsp/stereo/validation/winner_margin.h"

namespace stof::dsp {
namespace {

constexpr int kRowsCopied = 16;  // by a thread at once

bool keeps_weak(const MatchParams& params) noexcept {
  return params.confidence && (params.distinct || params.min_texture);
}

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

MapChecks::MapChecks(const MatchParams& params, int width, int height,
                     ImageView<std::int16_t> margins, Arena& arena, const ThreadTeam& team) noexcept
    : params_(params), team_(team), margins_(margins) {
  if (params.median || keeps_weak(params)) {
    spare_ = arena.take_passing_image<Disparity>(width, height);
  }
  if (keeps_weak(params)) {
    // Margins are of no use once the indistinct ones are dropped.
    weak_ = params.distinct
                ? ImageView<Disparity>(
                      reinterpret_cast<Disparity*>(margins_.data()),  // NOLINT: both are an i16
                      width, height)
                : arena.take_image<Disparity>(width, height);
  }
  for (int thread = 0; thread < team.threads() && (params.distinct || params.min_texture);
       ++thread) {
    windows_[index(thread)] = WindowSums(width, arena);
  }
  if (params.histogram_permille) {
    counts_ = arena.take_passing<std::uint32_t>(index(params.disparities) + 1);
  }
  if (params.speckle_pixels) {
    speckles_[0] = SpeckleScratch(width, height, arena);
    // Two threads do both maps at the same time, one does one after the other.
    speckles_[1] = keeps_weak(params) && team.threads() > 1 ? SpeckleScratch(width, height, arena)
                                                            : speckles_[0];
  }
}

// job(Rows) for all rows, by the team.
template <typename Job>
void MapChecks::by_rows(Job&& job) const noexcept {
  team_.run_rows({0, height_}, kRowsCopied, [&](Rows rows, int) noexcept { job(rows); });
}

void MapChecks::start(int width, int height) noexcept {
  width_ = width;
  height_ = height;
}

void MapChecks::apply(const PreparedPair& pair, ImageView<Disparity> map) noexcept {
  drop_by_surroundings(pair, map);
  if (params_.histogram_permille) {
    drop_rare(map, params_.min_disparity, *params_.histogram_permille, counts_);
  }
  if (params_.speckle_pixels) {
    drop_specks(map);
  }
  keep_weak(map);
  if (params_.median) {
    const ImageView<Disparity> copy = cut(spare_, width_, height_);
    by_rows([&](Rows rows) noexcept { copy_rows(map, rows, copy); });
    by_rows([&](Rows rows) noexcept { best::median_disparity(copy, rows, map); });
  }
}

void MapChecks::drop_by_surroundings(const PreparedPair& pair, ImageView<Disparity> map) noexcept {
  if (!params_.min_texture && !params_.distinct) {
    return;
  }
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  const ImageView<const std::int16_t> margins = cut(margins_, width_, height_);
  // Few large stripes: each begins its sums over 24 rows anew.
  const int stripes = team_.threads() == 1 ? 1 : 2 * team_.threads();
  const int step = (height_ + stripes - 1) / stripes;
  team_.run_rows(map.rows(), step, [&](Rows rows, int thread) noexcept {
    WindowSums& window = windows_[index(thread)];
    if (!weak_.empty()) {
      copy_rows(map, rows, before);
    }
    if (params_.min_texture) {
      drop_flat(pair.left(), *params_.prefilter_cap, *params_.min_texture, rows, window, map);
    }
    if (params_.distinct) {
      drop_small_margins(margins, rows, window, map);
    }
  });
}

// Of the map, and of what was there before its checks.
void MapChecks::drop_specks(ImageView<Disparity> map) noexcept {
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  team_.run(weak_.empty() ? 1 : 2, [&](int part, int) noexcept {
    drop_speckles(part == 0 ? map : before, *params_.speckle_pixels, speckles_[index(part)]);
  });
}

// Of what was consistent, what was dropped since.
void MapChecks::keep_weak(ImageView<const Disparity> map) noexcept {
  const ImageView<Disparity> weak = cut(weak_, width_, height_);
  if (weak.empty()) {
    return;
  }
  const ImageView<Disparity> before = cut(spare_, width_, height_);
  by_rows([&](Rows rows) noexcept {
    for (int y = rows.begin; y < rows.end; ++y) {
      keep_dropped(before.row(y), map.row(y), weak.row(y));
    }
  });
}

ImageView<const Disparity> MapChecks::weak() const noexcept { return cut(weak_, width_, height_); }

}  // namespace stof::dsp

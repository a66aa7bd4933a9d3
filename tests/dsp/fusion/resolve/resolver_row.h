#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/stereo/disparity_table.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"

namespace stof::dsp {

// f b = 100 px m: 50 px are 2 m (8000), 25 px are 4 m (16000).
inline constexpr StereoRig kRig{.left = {.width = 640, .height = 1, .fx = 1000, .fy = 1000},
                                .baseline_m = 0.1};
inline constexpr std::uint8_t kSure = 20;

// A row of pixels before it is resolved. Everything starts as "nothing seen".
struct ResolverRow {
  explicit ResolverRow(std::size_t n)
      : disparity(n),
        weak(n),
        stereo_low(n),
        stereo_high(n),
        pmd_low(n),
        pmd_high(n),
        reading(n),
        ratio(n, 255),
        flags(n),
        depth(n),
        width(n),
        source(n),
        cause(n),
        bounds(129 * 16 + 1 + 2 * kMostHalfWidth),
        table(make_disparity_table(kRig, -16, 40000, bounds)) {}

  void match(std::size_t from, std::size_t to, int px, std::uint8_t with_ratio = kSure) {
    for (std::size_t x = from; x < to; ++x) {
      disparity[x] = Disparity::from_pixels(px);
      ratio[x] = with_ratio;
      const DepthInterval interval = table.at(disparity[x].raw, 8);
      stereo_low[x] = interval.low;
      stereo_high[x] = interval.high;
    }
  }
  void see(std::size_t from, std::size_t to, QuarterMm low, QuarterMm high,
           std::uint8_t with_flags = 0) {
    for (std::size_t x = from; x < to; ++x) {
      pmd_low[x] = low;
      pmd_high[x] = high;
      reading[x] = middle_of(low, high);
      flags[x] = with_flags;
    }
  }
  FusedRow out() { return {depth, width, source, cause}; }
  void resolve(int reach_px = 1000, QuarterMm pmd_range = 0, int doubt_px = 0,
               bool wide_pmd = false) {
    ref::intersect({stereo_low, stereo_high}, {pmd_low, pmd_high}, {ratio, flags}, 40000, out());
    resolve_ambiguities({.disparity = disparity,
                         .weak = weak,
                         .stereo = {stereo_low, stereo_high},
                         .pmd = {pmd_low, pmd_high},
                         .reading = reading,
                         .support = {ratio, flags},
                         .picture = picture,
                         .view = !around.empty() ? around
                                 : viewed        ? ImageView<const Disparity>(
                                                disparity.data(), static_cast<int>(ratio.size()), 1,
                                                static_cast<int>(ratio.size()))
                                          : ImageView<const Disparity>(),
                         .y = y},
                        {.infinity_raw = 0,
                         .max_range = 40000,
                         .pmd_range = pmd_range,
                         .reach_px = reach_px,
                         .wide_pmd = wide_pmd,
                         .doubt_px = doubt_px},
                        table, out());
  }
  int low(std::size_t x) const { return depth[x] - width[x] / 2; }
  int high(std::size_t x) const { return depth[x] + width[x] / 2; }
  void expect(std::size_t x, Source want, Cause why, int near_depth) {
    EXPECT_EQ(source[x], want) << x;
    EXPECT_EQ(cause[x], why) << x;
    EXPECT_NEAR(depth[x], near_depth, 0.05 * near_depth) << x;
  }

  std::vector<Disparity> disparity, weak;
  std::vector<QuarterMm> stereo_low, stereo_high, pmd_low, pmd_high, reading;
  std::vector<std::uint8_t> ratio, flags;
  std::vector<std::uint8_t> picture;  // empty, or n
  bool viewed = false;                // the row belongs to a view of the pair
  ImageView<const Disparity> around;  // in place of a view of one row: the row is its row y
  int y = 0;
  std::vector<QuarterMm> depth, width;
  std::vector<Source> source;
  std::vector<Cause> cause;
  std::vector<DepthInterval> bounds;
  DisparityTable table;
};

}  // namespace stof::dsp

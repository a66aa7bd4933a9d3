#include "lab/matcher.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

namespace stof::lab {
namespace {

// Parts one after the other, the last first, as if by several threads.
struct Backwards {
  static constexpr int kMost = ThreadTeam::kMost;
  static int threads() { return kMost; }
  static void run(int parts, int threads, PartJob::Call* call, void* object) {
    for (int part = parts - 1; part >= 0; --part) {
      call(object, part, part % threads);
    }
  }
};

using Pixels = std::vector<std::uint8_t>;

int clamped(const Pixels& image, int width, int height, int x, int y) {
  return image[static_cast<std::size_t>(std::clamp(y, 0, height - 1) * width +
                                        std::clamp(x, 0, width - 1))];
}

constexpr int kNone = std::numeric_limits<int>::min();

// Columns with a single candidate take it where the neighbour with two has a match.
void match_ends(std::span<int> row, const MatchParams& p) {
  const int w = static_cast<int>(row.size());
  for (int x = 0; x < w && p.disparities > 1; ++x) {
    std::vector<int> inside;
    for (int d = p.min_disparity; d < p.min_disparity + p.disparities; ++d) {
      if (x - d >= 0 && x - d < w) {
        inside.push_back(d);
      }
    }
    const int neighbour = !inside.empty() && inside.front() == p.min_disparity ? x + 1 : x - 1;
    if (inside.size() == 1 && neighbour >= 0 && neighbour < w &&
        row[static_cast<std::size_t>(neighbour)] != kNone) {
      row[static_cast<std::size_t>(x)] = inside.front();
    }
  }
}

// The definition, sum by sum: grey values, no checks.
std::vector<int> brute_force(const Pixels& left, const Pixels& right, int w, int h,
                             const MatchParams& p) {
  std::vector<int> out;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      int best = std::numeric_limits<int>::max();
      int worst = -1;
      int winner = kNone;
      for (int d = p.min_disparity; d < p.min_disparity + p.disparities; ++d) {
        if (x - d < 0 || x - d >= w) {
          continue;
        }
        int sum = 0;
        for (int v = y - p.block_height / 2; v < y - p.block_height / 2 + p.block_height; ++v) {
          for (int u = x - p.block_width / 2; u < x - p.block_width / 2 + p.block_width; ++u) {
            sum += std::abs(clamped(left, w, h, u, v) - clamped(right, w, h, u - d, v));
          }
        }
        worst = std::max(worst, sum);
        if (sum < best) {
          best = sum;
          winner = d;
        }
      }
      out.push_back(best < worst ? winner : kNone);
    }
    match_ends(std::span(out).last(static_cast<std::size_t>(w)), p);
  }
  return out;
}

Pixels noise(int width, int height, std::uint64_t seed, int high = 255) {
  Pixels out(static_cast<std::size_t>(width * height));
  test::Random(seed).fill(std::span(out), 0, high);
  return out;
}

std::vector<Disparity> match(const Pixels& left, const Pixels& right, int w, int h,
                             const MatchParams& params, const ThreadTeam& team = {}) {
  test::GuardedPart<Matcher> matcher(
      [&](Arena& arena) { return Matcher(params, w, h, arena, team); });
  std::vector<Disparity> out(left.size());
  matcher->match({.left = {left.data(), w, h}, .right = {right.data(), w, h}}, {out.data(), w, h});
  return out;
}

TEST(Matcher, EqualsTheDefinitionForBlocksSizesAndRanges) {
  struct Case {
    int w, h, block_w, block_h, min, disparities;
  };
  for (const Case c :
       {Case{1, 1, 1, 1, 0, 1}, Case{1, 1, 16, 16, 0, 64}, Case{5, 3, 16, 16, 0, 16},
        Case{23, 9, 3, 5, 0, 17}, Case{40, 11, 16, 16, 0, 33}, Case{31, 8, 4, 1, -9, 20},
        Case{30, 7, 1, 4, 3, 12}, Case{19, 6, 64, 64, 0, 16}, Case{17, 5, 30, 10, -40, 80},
        Case{33, 4, 60, 20, 0, 256}}) {
    const MatchParams params{{.min_disparity = c.min,
                              .disparities = c.disparities,
                              .block_width = c.block_w,
                              .block_height = c.block_h,
                              .prefilter_cap = std::nullopt,
                              .left_right_tolerance = std::nullopt}};
    for (const int high : {3, 255}) {
      const Pixels left = noise(c.w, c.h, 1, high);
      const Pixels right = noise(c.w, c.h, 2, high);
      const std::vector<int> expected = brute_force(left, right, c.w, c.h, params);
      const std::vector<Disparity> found = match(left, right, c.w, c.h, params);
      for (std::size_t i = 0; i < found.size(); ++i) {
        const Disparity wanted =
            expected[i] == kNone ? Disparity::none() : Disparity::from_pixels(expected[i]);
        ASSERT_EQ(found[i], wanted)
            << c.w << "x" << c.h << " block " << c.block_w << "x" << c.block_h << " pixel " << i;
      }
    }
  }
}

TEST(Matcher, FindsAKnownShiftWithEveryOption) {
  const int w = 96;
  const int h = 24;
  const Pixels wide = noise(w + 20, h, 5);
  for (const int shift : {-6, 0, 9}) {
    Pixels left, right;
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {  // left(x) = right(x - shift)
        left.push_back(wide[static_cast<std::size_t>(y * (w + 20) + x + 10)]);
        right.push_back(wide[static_cast<std::size_t>(y * (w + 20) + x + 10 + shift)]);
      }
    }
    const MatchParams params{{.min_disparity = -8,
                              .disparities = 24,
                              .block_width = 9,
                              .block_height = 9,
                              .left_right_tolerance = 0,
                              .subpixel = Subpixel::kEquiangular}};
    const std::vector<Disparity> found = match(left, right, w, h, params);
    for (int y = 6; y < h - 6; ++y) {
      for (int x = 26; x < w - 26; ++x) {
        const Disparity d = found[static_cast<std::size_t>(y * w + x)];
        ASSERT_TRUE(d.valid());
        ASSERT_NEAR(d.pixels(), shift, 0.25);
      }
    }
  }
}

// One of each kind: presets, methods, costs, shapes, checks and fits.
std::vector<MatchParams> every_kind() {
  const auto with = [](auto change) {
    MatchParams params{{.disparities = 20, .block_width = 5, .block_height = 4}};
    change(params);
    return params;
  };
  std::vector<MatchParams> kinds;
  for (const char* const name : {"fast", "quality", "chapter"}) {
    kinds.push_back(as_the_appliance(find_preset(name)->params));
    kinds.back().disparities = 20;
    kinds.back().min_disparity = -3;
    kinds.push_back(kinds.back());
    kinds.back().fill = true;
  }
  for (const Method method :
       {Method::kDynamicProgramming, Method::kScanlineOptimisation, Method::kSemiGlobal}) {
    for (const Cost cost :
         {Cost::kSad, Cost::kSsd, Cost::kCensus5x5, Cost::kCensus9x7, Cost::kAdCensus}) {
      kinds.push_back(with([&](MatchParams& p) { p.method = method, p.cost = cost; }));
    }
  }
  for (const Subpixel fit : {Subpixel::kParabola, Subpixel::kLeastSquares}) {
    kinds.push_back(with([&](MatchParams& p) { p.subpixel = fit, p.smooth = true; }));
  }
  for (const BlockShape shape : {BlockShape::kCross, BlockShape::kRegion}) {
    kinds.push_back(with([&](MatchParams& p) { p.block_shape = shape, p.block_width = 20; }));
  }
  for (const Interest interest : {Interest::kMaxima, Interest::kTwoThresholds}) {
    kinds.push_back(with([&](MatchParams& p) { p.interest = interest; }));
  }
  for (const int levels : {1, 2}) {
    kinds.push_back(with([&](MatchParams& p) { p.pyramid_levels = levels, p.median = true; }));
  }
  kinds.push_back(
      with([](MatchParams& p) { p.method = Method::kScanlineOptimisation, p.band = 2; }));
  kinds.push_back(with([](MatchParams& p) { p.method = Method::kSemiGlobal, p.directions = 8; }));
  kinds.push_back(with([](MatchParams& p) { p.uniqueness_percent = 5, p.min_texture = 6; }));
  kinds.push_back(with([](MatchParams& p) { p.prefilter_cap.reset(), p.equalise = true; }));
  return kinds;
}

TEST(Matcher, ResultDoesNotDependOnTheSplitOfRows) {
  const int w = 50;
  const int h = 41;
  const Pixels left = noise(w, h, 8, 20);
  const Pixels right = noise(w, h, 9, 20);
  std::size_t kind = 0;
  for (const MatchParams& params : every_kind()) {
    const std::vector<Disparity> whole = match(left, right, w, h, params);
    for (const int threads : {1, 2, 3, ThreadTeam::kMost}) {
      Backwards pool;
      ASSERT_EQ(match(left, right, w, h, params, ThreadTeam(pool, threads)), whole)
          << "kind " << kind << ", " << threads << " threads";
    }
    ++kind;
  }
}

TEST(Matcher, WhatMatchesWellIsDistinctByEveryMethodAndCost) {
  const int w = 90;
  const int h = 40;
  const Pixels left = noise(w, h, 11);
  Pixels right = left;
  for (int y = 0; y < h; ++y) {
    std::rotate(right.begin() + y * w, right.begin() + y * w + 5, right.begin() + (y + 1) * w);
  }
  for (const Method method : {Method::kWinnerTakesAll, Method::kDynamicProgramming,
                              Method::kScanlineOptimisation, Method::kSemiGlobal}) {
    for (const Cost cost :
         {Cost::kSad, Cost::kSsd, Cost::kCensus5x5, Cost::kCensus9x7, Cost::kAdCensus}) {
      for (const std::optional<int> cap : {std::optional<int>(), std::optional<int>(15)}) {
        MatchParams params{{.disparities = 32,
                            .block_width = 9,
                            .block_height = 9,
                            .prefilter_cap = cap,
                            .distinct = true}};
        params.cost = cost;
        params.method = method;
        const std::vector<Disparity> found = match(left, right, w, h, params);
        const auto right_ones = std::ranges::count(found, Disparity::from_pixels(5));
        EXPECT_GE(right_ones, w * h * 8 / 10) << static_cast<int>(method) << ", "
                                              << static_cast<int>(cost) << ", " << cap.value_or(0);
      }
    }
  }
}

TEST(Matcher, EveryKindTakesEverySize) {
  const int sizes[][2] = {{1, 1}, {2, 1}, {1, 2}, {3, 2}, {1, 40}, {70, 1}, {19, 35}, {90, 3}};
  for (const auto& [w, h] : sizes) {
    std::size_t kind = 0;
    for (const MatchParams& params : every_kind()) {
      const std::vector<Disparity> found = match(noise(w, h, 1), noise(w, h, 2), w, h, params);
      const int last = (params.min_disparity + params.disparities) * Disparity::kOne;
      for (const Disparity d : found) {
        ASSERT_TRUE(!d.valid() ||
                    (d.raw >= (params.min_disparity - 1) * Disparity::kOne && d.raw <= last))
            << w << "x" << h << ", kind " << kind;
      }
      ++kind;
    }
  }
}

TEST(Matcher, MarksWhatItFillsAndNothingElse) {
  const int w = 60;
  const int h = 30;
  const Pixels left = noise(w, h, 1);
  const Pixels right = noise(w, h, 2);
  MatchParams params{{.disparities = 16, .left_right_tolerance = 0}};
  const std::vector<Disparity> checked = match(left, right, w, h, params);
  params.fill = true;
  test::GuardedPart<Matcher> matcher([&](Arena& arena) { return Matcher(params, w, h, arena); });
  std::vector<Disparity> out(left.size());
  matcher->match({.left = {left.data(), w, h}, .right = {right.data(), w, h}}, {out.data(), w, h});
  const ImageView<const std::uint8_t> filled = matcher->filled();
  ASSERT_TRUE(std::ranges::any_of(checked, [](Disparity d) { return !d.valid(); }));
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const std::size_t i = static_cast<std::size_t>(y * w + x);
      ASSERT_EQ(filled.at(x, y), out[i].valid() && !checked[i].valid() ? 1 : 0);
    }
  }
}

TEST(Matcher, FillsNothingWhereNothingIsSure) {
  const int w = 80;
  const int h = 40;
  MatchParams params = as_the_appliance(dsp::find_preset("quality")->params);
  params.fill = true;
  for (const Pixels& picture : {Pixels(w * h, 0), Pixels(w * h, 255)}) {
    EXPECT_EQ(match(picture, picture, w, h, params),
              std::vector<Disparity>(picture.size(), Disparity::none()));
  }
}

TEST(Matcher, FillsAPictureBesideItselfWithZeros) {
  const int w = 60;
  const int h = 30;
  const Pixels left = noise(w, h, 1);
  MatchParams params{{.disparities = 16, .left_right_tolerance = 0}};
  params.fill = true;
  const std::vector<Disparity> out = match(left, left, w, h, params);
  EXPECT_EQ(out, std::vector<Disparity>(left.size(), Disparity::from_pixels(0)));
}

TEST(Matcher, SmallerImageThanReservedGivesTheSameResult) {
  const MatchParams params{{.disparities = 16, .left_right_tolerance = 1}};
  const Pixels left = noise(30, 9, 3);
  const Pixels right = noise(30, 9, 4);
  test::GuardedPart<Matcher> matcher([&](Arena& arena) { return Matcher(params, 64, 40, arena); });
  std::vector<Disparity> out(left.size());
  matcher->match({.left = {left.data(), 30, 9}, .right = {right.data(), 30, 9}},
                 {out.data(), 30, 9});
  EXPECT_EQ(out, match(left, right, 30, 9, params));
}

TEST(Matcher, FlatBlackAndSaturatedImagesGiveNoDisparity) {
  for (const int value : {0, 128, 255}) {
    const Pixels flat(60 * 20, static_cast<std::uint8_t>(value));
    for (const std::optional<int> tolerance : {std::optional<int>(), std::optional<int>(1)}) {
      const std::vector<Disparity> found = match(flat, flat, 60, 20,
                                                 {{.disparities = 64,
                                                   .left_right_tolerance = tolerance,
                                                   .subpixel = Subpixel::kEquiangular}});
      EXPECT_TRUE(std::ranges::none_of(found, &Disparity::valid)) << "grey " << value;
    }
  }
}

TEST(Matcher, RangeOutsideTheImageGivesNone) {
  const Pixels image = noise(10, 4, 1);
  const std::vector<Disparity> found =
      match(image, image, 10, 4, {{.min_disparity = 100, .disparities = 8}});
  EXPECT_TRUE(std::ranges::none_of(found, &Disparity::valid));
}

TEST(Matcher, RefusesParametersOutOfRange) {
  const auto judged = [](const dsp::MatchParams& params, int width = 640) {
    return check(MatchParams{params}, width, 480);
  };
  EXPECT_EQ(judged({}), Status::kOk);
  EXPECT_EQ(judged({}, 0), Status::kInvalidArgument);
  EXPECT_EQ(judged({.disparities = 0}), Status::kInvalidArgument);
  EXPECT_EQ(judged({.block_width = 0}), Status::kInvalidArgument);
  EXPECT_EQ(judged({.prefilter_cap = 0}), Status::kInvalidArgument);
  EXPECT_EQ(judged({.block_height = 65}), Status::kTooLarge);
  EXPECT_EQ(judged({.disparities = 257}), Status::kTooLarge);
  EXPECT_EQ(judged({}, 5000), Status::kTooLarge);
}

}  // namespace
}  // namespace stof::lab

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/index.h"
#include "lab/matcher.h"
#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

// A Matcher with a guide, the appliance's and the lab's.
namespace stof::lab {
namespace {

using Pixels = std::vector<std::uint8_t>;
using Ranges = std::vector<Candidates>;
using Map = std::vector<Disparity>;

struct Pair {
  int width;
  int height;
  Pixels left;
  Pixels right;
};

// Parts one after the other, the last first, as if by several threads.
struct Backwards {
  static constexpr int kMost = 3;
  static int threads() { return kMost; }
  static void run(int parts, int threads, PartJob::Call* call, void* object) {
    for (int part = parts - 1; part >= 0; --part) {
      call(object, part, part % threads);
    }
  }
};

class Bench {
 public:
  explicit Bench(const MatchParams& params, const Pair& pair, const ThreadTeam& team = {})
      : pair_(pair), matcher_([&](Arena& arena) {
          return Matcher(params, pair.width, pair.height, arena, team);
        }) {}

  Map match(const Ranges& ranges) {
    Map out(pair_.left.size());
    matcher_->match({.left = left(), .right = right(), .guide = guide(ranges)}, view(out));
    return out;
  }

 private:
  ImageView<const std::uint8_t> left() const {
    return {pair_.left.data(), pair_.width, pair_.height};
  }
  ImageView<const std::uint8_t> right() const {
    return {pair_.right.data(), pair_.width, pair_.height};
  }
  ImageView<Disparity> view(Map& map) const { return {map.data(), pair_.width, pair_.height}; }
  Guide guide(const Ranges& ranges) const {
    return ranges.empty() ? Guide{} : Guide{ranges.data(), pair_.width, pair_.height};
  }

  const Pair& pair_;
  test::GuardedPart<Matcher> matcher_;
};

Map match(const MatchParams& params, const Pair& pair, const Ranges& ranges) {
  return Bench(params, pair).match(ranges);
}

Pair noise(int width, int height, std::uint64_t seed, int high = 255) {
  Pair pair{width, height, Pixels(index(width * height)), Pixels(index(width * height))};
  test::Random random(seed);
  random.fill(std::span(pair.left), 0, high);
  random.fill(std::span(pair.right), 0, high);
  return pair;
}

// left(x) = right(x - shift(x, y)), over a texture that no other shift matches.
template <typename Shift>
Pair shifted(int width, int height, Shift shift) {
  Pair pair = noise(width, height, 11);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int from = x - shift(x, y);
      if (from >= 0 && from < width) {
        pair.left[index(y * width + x)] = pair.right[index(y * width + from)];
      }
    }
  }
  return pair;
}

Ranges some_ranges(const Pair& pair, int candidates, std::uint64_t seed) {
  Ranges ranges(pair.left.size());
  test::Random random(seed);
  for (Candidates& may : ranges) {
    if (random.between(0, 3) != 0) {
      may = {static_cast<std::uint8_t>(random.between(0, candidates - 1)),
             static_cast<std::uint8_t>(random.between(0, candidates + 3))};
    }
  }
  return ranges;
}

// One of each search, cost, width of sums and check.
std::vector<MatchParams> every_kind() {
  std::vector<MatchParams> all;
  for (const char* const name : {"fast", "quality", "chapter"}) {
    all.push_back(as_the_appliance(find_preset(name)->params));
  }
  for (const Method method : {Method::kWinnerTakesAll, Method::kDynamicProgramming,
                              Method::kScanlineOptimisation, Method::kSemiGlobal}) {
    all.push_back(method_defaults(method));
    all.back().cost = Cost::kSsd;  // u32 sums but for semi-global
    all.push_back(method_defaults(method));
    all.back().cost = Cost::kAdCensus;
    all.back().left_right_tolerance = 1;
    all.push_back(method_defaults(method));
    all.back().cost = Cost::kCensus5x5;
    all.back().uniqueness_percent = 5;
    all.back().subpixel = Subpixel::kParabola;
  }
  all.push_back(method_defaults(Method::kSemiGlobal));
  all.back().cost = Cost::kAdCensus;
  all.back().directions = 8;
  all.push_back(method_defaults(Method::kScanlineOptimisation));
  all.back().band = 2;
  all.push_back({});
  all.back().interest = Interest::kMaxima;
  for (MatchParams& params : all) {
    params.disparities = 20;
    params.guided = true;
  }
  return all;
}

constexpr int kNone = std::numeric_limits<int>::min();

// Winner takes all on grey values with a left-right check of tolerance 0, sum by sum.
class Definition {
 public:
  Definition(const Pair& pair, const MatchParams& params, const Ranges& ranges)
      : pair_(pair), params_(params), ranges_(ranges) {}

  int at(int x, int y) const {
    const int winner = left_winner(x, y);
    const Candidates may = ranges_[index(y * pair_.width + x)];
    if (winner == kNone || winner < may.first || winner > may.last) {
      return kNone;
    }
    return right_winner(x - params_.min_disparity - winner, y) == winner ? winner : kNone;
  }

 private:
  bool offered(int x, int y, int i) const {
    const Candidates may = ranges_[index(y * pair_.width + x)];
    const int column = x - params_.min_disparity - i;
    return column >= 0 && column < pair_.width && i >= may.first - 1 && i <= may.last + 1;
  }
  int cost(int x, int y, int i) const {
    const auto grey = [&](const Pixels& image, int u, int v) {
      return image[index(std::clamp(v, 0, pair_.height - 1) * pair_.width +
                         std::clamp(u, 0, pair_.width - 1))];
    };
    int sum = 0;
    const int left = params_.block_width / 2;
    const int above = params_.block_height / 2;
    for (int v = y - above; v < y - above + params_.block_height; ++v) {
      for (int u = x - left; u < x - left + params_.block_width; ++u) {
        sum +=
            std::abs(grey(pair_.left, u, v) - grey(pair_.right, u - params_.min_disparity - i, v));
      }
    }
    return sum;
  }
  int left_winner(int x, int y) const {
    int best = std::numeric_limits<int>::max();
    int worst = -1;
    int winner = kNone;
    for (int i = 0; i < params_.disparities; ++i) {
      const int sum = offered(x, y, i) ? cost(x, y, i) : best;
      worst = offered(x, y, i) ? std::max(worst, sum) : worst;
      if (sum < best) {
        best = sum;
        winner = i;
      }
    }
    return best < worst ? winner : kNone;
  }
  int right_winner(int column, int y) const {
    int best = std::numeric_limits<int>::max();
    int winner = kNone;
    for (int i = 0; i < params_.disparities; ++i) {
      const int x = column + params_.min_disparity + i;
      if (x >= 0 && x < pair_.width && offered(x, y, i) && cost(x, y, i) < best) {
        best = cost(x, y, i);
        winner = i;
      }
    }
    return winner;
  }

  const Pair& pair_;
  const MatchParams& params_;
  const Ranges& ranges_;
};

TEST(GuidedMatcher, EqualsTheFullSearchWithMaskedCosts) {
  for (const int first : {0, -7, 4}) {
    for (const int block : {1, 5}) {
      for (const int high : {3, 255}) {
        const Pair pair = noise(47, 6, 3, high);
        const MatchParams params{{.min_disparity = first,
                                  .disparities = 18,
                                  .block_width = block,
                                  .block_height = block,
                                  .prefilter_cap = std::nullopt,
                                  .guided = true,
                                  .left_right_tolerance = 0}};
        const Ranges ranges = some_ranges(pair, 18, 5);
        const Map found = match(params, pair, ranges);
        const Definition definition(pair, params, ranges);
        // Columns with one candidate inside the right picture follow their neighbours.
        const int last = pair.width + first + 16;
        for (int y = 0; y < pair.height; ++y) {
          for (int x = 0; x < pair.width; ++x) {
            if (x == first || x == last) {
              continue;
            }
            const int wanted = definition.at(x, y);
            ASSERT_EQ(found[index(y * pair.width + x)],
                      wanted == kNone ? Disparity::none() : Disparity::from_pixels(first + wanted))
                << x << ", " << y << " from " << first << " block " << block;
          }
        }
      }
    }
  }
}

TEST(GuidedMatcher, AGuideThatLeavesOutNothingChangesNothing) {
  const Pair pair = shifted(90, 40, [](int x, int) { return x < 40 ? 4 : 11; });
  for (MatchParams params : every_kind()) {
    const Map open = match(params, pair, Ranges(pair.left.size()));
    const Map all = match(params, pair, Ranges(pair.left.size(), Candidates{0, 19}));
    const Map none = match(params, pair, {});
    params.guided = false;
    const Map free = match(params, pair, {});
    EXPECT_EQ(open, free);
    EXPECT_EQ(all, free);
    EXPECT_EQ(none, free);
  }
}

TEST(GuidedMatcher, NoPixelLeavesItsRangeAndNoSplitMatters) {
  const Pair pair = shifted(70, 45, [](int, int y) { return y < 20 ? 4 : 11; });
  const Ranges ranges = some_ranges(pair, 20, 9);
  for (MatchParams params : every_kind()) {
    Bench bench(params, pair);
    const Map whole = bench.match(ranges);
    int found = 0;
    for (std::size_t k = 0; k < whole.size() && !params.median; ++k) {
      if (whole[k].valid()) {
        ++found;
        // Half a candidate is what a fit may add.
        EXPECT_GE(whole[k].raw, ranges[k].first * Disparity::kOne - 8);
        EXPECT_LE(whole[k].raw, ranges[k].last * Disparity::kOne + 8);
      }
    }
    EXPECT_TRUE(params.median || found > 0);
    Backwards pool;
    EXPECT_EQ(Bench(params, pair, ThreadTeam(pool, 3)).match(ranges), whole);
  }
}

TEST(GuidedMatcher, FindsWhatTheRangesHoldByEveryMethod) {
  const auto truth = [](int x, int) { return x < 60 ? 4 : 13; };
  const Pair pair = shifted(120, 48, truth);
  Ranges ranges(pair.left.size());
  for (int y = 0; y < pair.height; ++y) {
    for (int x = 0; x < pair.width; ++x) {
      // Of neighbours that have no candidate in common.
      const auto d = static_cast<std::uint8_t>(truth(x, y));
      ranges[index(y * pair.width + x)] = {static_cast<std::uint8_t>(d - 2),
                                           static_cast<std::uint8_t>(d + 2)};
    }
  }
  for (const MatchParams& params : every_kind()) {
    if (params.interest) {
      continue;  // few positions
    }
    const Map found = match(params, pair, ranges);
    int right = 0;
    int wrong = 0;
    for (int y = 0; y < pair.height; ++y) {
      for (int x = 20; x < pair.width; ++x) {
        const Disparity d = found[index(y * pair.width + x)];
        if (d.valid()) {
          const bool good = std::abs(d.raw - truth(x, y) * Disparity::kOne) < Disparity::kOne;
          ++(good ? right : wrong);
        }
      }
    }
    EXPECT_GT(right, 70 * pair.height);  // of 100 columns, some around the step and the border
    EXPECT_LT(wrong, right / 20);
  }
}

TEST(GuidedMatcher, TellsThePeriodsOfAPatternApart) {
  Pair pair{128, 40, {}, {}};
  for (int y = 0; y < pair.height; ++y) {
    for (int x = 0; x < pair.width; ++x) {
      // Repeats after 8 px: 11 and 3 match alike.
      const auto grey = [&](int u) { return static_cast<std::uint8_t>(60 + 20 * ((u + 800) % 8)); };
      pair.left.push_back(grey(x - 11));
      pair.right.push_back(grey(x));
    }
  }
  const MatchParams params{{.disparities = 20, .guided = true, .left_right_tolerance = 1}};
  const auto at_middle = [&](const Ranges& ranges) {
    return match(params, pair, ranges)[index(20 * pair.width + 80)];
  };
  EXPECT_EQ(at_middle({}), Disparity::from_pixels(3));
  EXPECT_EQ(at_middle(Ranges(pair.left.size(), Candidates{9, 14})), Disparity::from_pixels(11));
  // Stereo contradicts a range that holds no match: its costs fall towards 11.
  EXPECT_FALSE(at_middle(Ranges(pair.left.size(), Candidates{13, 15})).valid());
}

TEST(GuidedMatcher, AFitAtTheEndOfARangeIsTheFitOfTheFullSearch) {
  // Half of one shift and half of the next: 6.5 px.
  const int w = 100;
  Pair pair = noise(w, 40, 21);
  for (std::size_t k = 7; k < pair.left.size(); ++k) {
    pair.left[k] = static_cast<std::uint8_t>((2 * pair.right[k - 6] + pair.right[k - 7] + 1) / 3);
  }
  for (const Subpixel fit : {Subpixel::kEquiangular, Subpixel::kParabola}) {
    const MatchParams params{{.disparities = 20, .guided = true, .subpixel = fit}};
    const Map free = match(params, pair, {});
    for (const Candidates may : {Candidates{6, 6}, Candidates{6, 12}, Candidates{1, 6}}) {
      const Map found = match(params, pair, Ranges(pair.left.size(), may));
      int compared = 0;
      for (int y = 8; y < 32; ++y) {
        for (int x = 30; x < 90; ++x) {
          const std::size_t k = index(y * w + x);
          if (free[k].valid() && (free[k].raw + 8) / Disparity::kOne == 6) {
            ++compared;
            EXPECT_EQ(found[k], free[k]) << x << ", " << y;
          }
        }
      }
      EXPECT_GT(compared, 1000);
    }
  }
}

TEST(GuidedMatcher, ARangeMakesNothingUpWhereNothingMatches) {
  const int w = 160;
  const int h = 80;
  const Ranges ranges(index(w * h), Candidates{7, 9});
  Pair flat{w, h, Pixels(index(w * h), 90), Pixels(index(w * h), 90)};
  for (const MatchParams& params : every_kind()) {
    const Map found = match(params, flat, ranges);
    EXPECT_EQ(std::ranges::count_if(found, &Disparity::valid), 0);
  }
  // A wall with the noise of a camera.
  for (const int level : {1, 3}) {
    Pair wall = noise(w, h, 31, 2 * level);
    for (std::size_t k = 0; k < wall.left.size(); ++k) {
      wall.left[k] = static_cast<std::uint8_t>(wall.left[k] + 100);
      wall.right[k] = static_cast<std::uint8_t>(wall.right[k] + 100);
    }
    for (const char* const name : {"fast", "quality"}) {
      MatchParams params = as_the_appliance(find_preset(name)->params);
      params.guided = true;
      const Map found = match(params, wall, ranges);
      EXPECT_LT(std::ranges::count_if(found, &Disparity::valid), w * h / 100) << name << level;
    }
  }
}

TEST(GuidedMatcher, RefusesSearchesWithoutCosts) {
  MatchParams params{{.guided = true}};
  params.block_shape = BlockShape::kCross;
  EXPECT_NE(*problem(params), '\0');
  EXPECT_EQ(check(params, 64, 64), Status::kInvalidArgument);
  params.block_shape = BlockShape::kFixed;
  params.pyramid_levels = 1;
  EXPECT_NE(*problem(params), '\0');
  params.guided = false;
  EXPECT_EQ(*problem(params), '\0');
}

}  // namespace
}  // namespace stof::lab

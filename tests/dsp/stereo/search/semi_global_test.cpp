#include "dsp/stereo/search/semi_global.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/index.h"
#include "dsp/stereo/search/path_costs.h"
#include "dsp/stereo/search/semi_global_body.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr int kLanes = 16;

// A picture and costs of noise around a surface, and how often each row was asked for.
template <typename Cost>
class Scene final : public CostSource<Cost> {
 public:
  Scene(int width, int height, std::uint64_t seed, int largest = 90)
      : width_(width), grey_(index(width * height)), costs_(index(width * height * kLanes)) {
    test::Random random(seed);
    random.fill(std::span(grey_));
    random.fill(std::span(costs_), 0, largest);
    asked_.resize(index(height));
  }
  void row(int y, std::span<Cost> costs) noexcept override {
    ++asked_[index(y)];
    std::ranges::copy(at(y), costs.begin());
  }
  std::span<const Cost> at(int y) const {
    const std::size_t n = index(width_ * kLanes);
    return std::span<const Cost>(costs_).subspan(index(y) * n, n);
  }
  ImageView<const std::uint8_t> grey() const {
    return {grey_.data(), width_, static_cast<int>(asked_.size())};
  }
  const std::vector<int>& asked() const { return asked_; }

 private:
  int width_;
  std::vector<std::uint8_t> grey_;
  std::vector<Cost> costs_;
  std::vector<int> asked_;
};

template <typename Cost>
PathParams<Cost> params(int directions) {
  return {.directions = directions, .lanes = kLanes, .penalties = {.small = 5, .large = 40}};
}

template <typename Cost, typename Sum = std::uint16_t>
using Map = std::vector<std::vector<Sum>>;

// The sums of all rows, asked for in the order of `rows`.
template <typename Sum, typename Cost>
Map<Cost, Sum> sums_of(Scene<Cost>& scene, const PathParams<Cost>& how,
                       const std::vector<int>& rows) {
  const int width = scene.grey().width();
  test::GuardedPart<SemiGlobal<Cost, Sum>> owned(
      [&](Arena& arena) { return SemiGlobal<Cost, Sum>(how, width, arena); });
  SemiGlobal<Cost, Sum>& semi_global = *owned;
  semi_global.start(scene.grey(), scene);
  Map<Cost, Sum> map(index(scene.grey().height()));
  for (const int y : rows) {
    const auto sums = semi_global.sums(y);
    map[index(y)].assign(sums.begin(), sums.end());
  }
  return map;
}

template <typename Cost>
Map<Cost> sums_of(Scene<Cost>& scene, int directions, const std::vector<int>& rows) {
  return sums_of<std::uint16_t>(scene, params<Cost>(directions), rows);
}

std::vector<int> in_order(int height) {
  std::vector<int> rows;
  for (int y = 0; y < height; ++y) {
    rows.push_back(y);
  }
  return rows;
}

// Paths of one direction over whole columns, straight from the definition.
template <typename Cost>
void add_direction(const Scene<Cost>& scene, int step, int shift, Map<Cost>& map) {
  const ImageView<const std::uint8_t> grey = scene.grey();
  const auto how = params<Cost>(4);
  std::vector<Cost> before;
  std::vector<Cost> large(index(grey.width()));
  for (int k = 0; k < grey.height(); ++k) {
    const int y = step > 0 ? k : grey.height() - 1 - k;
    std::vector<Cost> paths(scene.at(y).begin(), scene.at(y).end());
    if (k > 0) {
      edge_penalties_across(grey.row(y), grey.row(y - step), shift, how.penalties,
                            std::span(large));
      ref::paths_across<Cost>(scene.at(y), std::span<const Cost>(before), shift, kLanes,
                              how.penalties.small, std::span<const Cost>(large), std::span(paths));
    }
    for (std::size_t i = 0; i < paths.size(); ++i) {
      map[index(y)][i] = static_cast<std::uint16_t>(map[index(y)][i] + paths[i]);
    }
    before = paths;
  }
}

template <typename Cost>
Map<Cost> whole_columns(const Scene<Cost>& scene, int directions) {
  const ImageView<const std::uint8_t> grey = scene.grey();
  const auto how = params<Cost>(directions);
  Map<Cost> map(index(grey.height()));
  std::vector<Cost> large(index(grey.width()) + 1);
  for (int y = 0; y < grey.height(); ++y) {
    edge_penalties_along(grey.row(y), how.penalties, std::span(large));
    const std::span<const Cost> all(large);
    std::vector<Cost> left(scene.at(y).size());
    std::vector<Cost> right(left.size());
    ref::paths_along<Cost>(scene.at(y), kLanes, how.penalties.small, all.first(all.size() - 1),
                           true, std::span(left));
    ref::paths_along<Cost>(scene.at(y), kLanes, how.penalties.small, all.subspan(1), false,
                           std::span(right));
    for (std::size_t i = 0; i < left.size(); ++i) {
      map[index(y)].push_back(static_cast<std::uint16_t>(left[i] + right[i]));
    }
  }
  for (const int shift : {0, -1, 1}) {
    if (directions == 4 && shift != 0) {
      continue;
    }
    if (directions > 2) {
      add_direction(scene, 1, shift, map);
    }
    if (directions == 4 || directions == 8) {
      add_direction(scene, -1, shift, map);
    }
  }
  return map;
}

template <typename Cost>
void expect_the_definition_where_columns_are_short() {
  // No stripe is cut where the picture is as high as one approach.
  for (const int directions : {2, 4, 5, 8}) {
    for (const int height : {1, 2, SemiGlobal<Cost, std::uint16_t>::kStripe}) {
      Scene<Cost> scene(23, height, index(directions + height));
      EXPECT_EQ(sums_of(scene, directions, in_order(height)), whole_columns(scene, directions))
          << directions << " directions, " << height << " rows";
    }
  }
}

TEST(SemiGlobal, IsTheSumOverAllDirections) {
  expect_the_definition_where_columns_are_short<std::uint8_t>();
  expect_the_definition_where_columns_are_short<std::uint16_t>();
}

TEST(SemiGlobal, AgreesWithWholeColumnsOnNearlyEveryWinner) {
  const int height = 5 * SemiGlobal<std::uint8_t, std::uint16_t>::kStripe + 3;
  Scene<std::uint8_t> scene(40, height, 3);
  const Map<std::uint8_t> stripes = sums_of(scene, 4, in_order(height));
  const Map<std::uint8_t> whole = whole_columns(scene, 4);
  int differing = 0;
  for (std::size_t y = 0; y < index(height); ++y) {
    for (std::size_t x = 0; x < 40; ++x) {
      const auto winner = [&](const std::vector<std::uint16_t>& row) {
        const auto pixel = row.begin() + static_cast<std::ptrdiff_t>(x * kLanes);
        return std::min_element(pixel, pixel + kLanes) - pixel;
      };
      differing += winner(stripes[y]) != winner(whole[y]);
    }
  }
  EXPECT_LE(differing, 40 * height / 1000);
}

// From below, and jumping about.
std::vector<std::vector<int>> odd_orders(int height) {
  std::vector<int> backwards = in_order(height);
  std::ranges::reverse(backwards);
  std::vector<int> jumping;
  for (int k = 0; k < height; ++k) {
    jumping.push_back(k * 29 % height);
  }
  return {backwards, jumping};
}

TEST(SemiGlobal, RowsMayBeAskedForInAnyOrder) {
  const int height = 3 * SemiGlobal<std::uint8_t, std::uint16_t>::kStripe + 7;
  for (const int directions : {2, 4, 5, 8}) {
    Scene<std::uint8_t> scene(17, height, 9);
    const Map<std::uint8_t> expected = sums_of(scene, directions, in_order(height));
    for (const std::vector<int>& rows : odd_orders(height)) {
      EXPECT_EQ(sums_of(scene, directions, rows), expected);
    }
  }
}

// Sums of bytes are made in place, where all four directions are.
TEST(SemiGlobal, SumsOfBytesAreThoseOfWordsInAnyOrderOfRows) {
  const int height = 3 * SemiGlobal<std::uint8_t, std::uint8_t>::kStripe + 7;
  for (const int directions : {2, 4, 5, 8}) {
    // Eight paths of at most 10 + 15 fit a byte.
    Scene<std::uint8_t> scene(17, height, 9, 10);
    const PathParams<std::uint8_t> how{
        .directions = directions, .lanes = kLanes, .penalties = {.small = 2, .large = 15}};
    const Map<std::uint8_t> words = sums_of<std::uint16_t>(scene, how, in_order(height));
    Map<std::uint8_t, std::uint8_t> expected;
    for (const std::vector<std::uint16_t>& row : words) {
      EXPECT_LT(*std::ranges::max_element(row), 255);
      expected.emplace_back(row.begin(), row.end());
    }
    std::vector<std::vector<int>> orders = odd_orders(height);
    orders.push_back(in_order(height));
    for (const std::vector<int>& rows : orders) {
      EXPECT_EQ(sums_of<std::uint8_t>(scene, how, rows), expected) << directions << " directions";
    }
  }
}

TEST(SemiGlobal, InOrderEachRowOfCostsIsComputedOnce) {
  const int height = 4 * SemiGlobal<std::uint8_t, std::uint16_t>::kStripe;
  Scene<std::uint8_t> scene(17, height, 10);
  sums_of(scene, 8, in_order(height));
  EXPECT_EQ(scene.asked(), std::vector<int>(index(height), 1));
}

}  // namespace
}  // namespace stof::dsp

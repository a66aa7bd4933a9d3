#include "lab/pyramid/pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "dsp/base/target.h"
#include "dsp/stereo/prefilter/prefilter.h"
#include "dsp/stereo/search/winner.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"
#include "tests/support/recorded_scenes.h"

namespace stof::lab {
namespace {

using Picture = test::GuardedImage<std::uint8_t>;
using Map = test::GuardedImage<std::int16_t>;

struct Pair {
  int width;
  int height;
  Picture left;
  Picture right;

  Pair(int w, int h) : width(w), height(h), left(w, h, w), right(w, h, w) {}
  PyramidPictures pictures() {
    return {.left = left.view(),
            .right = right.view(),
            .left_grey = left.view(),
            .right_grey = right.view()};
  }
};

Pair noise(int width, int height, std::uint64_t seed) {
  Pair pair(width, height);
  test::Random random(seed);
  for (int y = 0; y < height; ++y) {
    random.fill(pair.left.view().row(y), 0, 40);
    random.fill(pair.right.view().row(y), 0, 40);
  }
  return pair;
}

// What winner.h says of one pixel, from block sums as sad.h says them.
class Plain {
 public:
  Plain(Pair& pair, const MatchParams& params) : pair_(pair), params_(params) {}

  bool offered(int x, int i) const {
    const int column = x - params_.min_disparity - i;
    return i < params_.disparities && column >= 0 && column < pair_.width;
  }
  int cost(int x, int y, int i) const {
    const auto clamped = [](ImageView<std::uint8_t> image, int column, int row) {
      return image.row_clamped(
          row)[static_cast<std::size_t>(std::clamp(column, 0, image.width() - 1))];
    };
    int sum = 0;
    for (int k = 0; k < params_.block_height; ++k) {
      for (int j = 0; j < params_.block_width; ++j) {
        const int column = x - params_.block_width / 2 + j;
        const int row = y - params_.block_height / 2 + k;
        sum += std::abs(clamped(pair_.left.view(), column, row) -
                        clamped(pair_.right.view(), column - params_.min_disparity - i, row));
      }
    }
    return sum;
  }
  int winner(int x, int y, CandidateRange range) const {
    int best = kNoWinner;
    bool differ = false;
    for (int i = range.first; i < range.first + range.lanes; ++i) {
      if (offered(x, i)) {
        differ = differ || (best != kNoWinner && cost(x, y, i) != cost(x, y, best));
        best = best == kNoWinner || cost(x, y, i) < cost(x, y, best) ? i : best;
      }
    }
    return differ ? best : kNoWinner;
  }
  int right_winner(int column, int y) const {
    int best = kNoWinner;
    for (int i = 0; i < params_.disparities; ++i) {
      const int x = column + params_.min_disparity + i;
      if (x >= 0 && x < pair_.width) {
        const int rival = best == kNoWinner ? 0 : column + params_.min_disparity + best;
        best = best == kNoWinner || cost(x, y, i) < cost(rival, y, best) ? i : best;
      }
    }
    return best;
  }

 private:
  Pair& pair_;
  const MatchParams& params_;
};

template <typename Sum>
class Patches : public testing::Test {
 protected:
  static void run(Pair& pair, const MatchParams& params, std::span<const CandidateRange> ranges,
                  Rows rows, const PatchWinners& out) {
    const bool check = !out.right.empty();
    test::GuardedBuffer<std::byte> memory(bytes_taken([&](Arena& measuring) {
      PatchSearch<Sum>(params, check, pair.width, pair.height, measuring);
    }));
    Arena arena(memory.span());
    PatchSearch<Sum> search(params, check, pair.width, pair.height, arena);
    search.start(pair.left.view(), pair.right.view());
    search.search(rows, ranges, out);
  }
};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Patches, Sums);

TYPED_TEST(Patches, SearchingEverythingIsWinnerTakesAllOfBothPictures) {
  struct Case {
    int width, height, min_disparity, disparities, block_width, block_height;
  };
  // With a cap the pass of block_winners.h serves, without one it does not.
  const std::optional<int> caps[] = {20, std::nullopt};
  for (const Case& c :
       {Case{1, 1, 0, 1, 1, 1}, Case{61, 7, 0, 16, 5, 4}, Case{100, 5, -9, 20, 3, 3},
        Case{17, 3, 4, 40, 6, 2}, Case{130, 2, -40, 33, 1, 5}, Case{450, 3, 2, 65, 7, 3}}) {
    Pair pair = noise(c.width, c.height, 3);
    MatchParams params{{.min_disparity = c.min_disparity,
                        .disparities = c.disparities,
                        .block_width = c.block_width,
                        .block_height = c.block_height}};
    for (const std::optional<int>& cap : caps) {
      params.prefilter_cap = cap;
      Map left(c.width, c.height, c.width), right(c.width, c.height, c.width);
      const std::vector<CandidateRange> ranges(
          static_cast<std::size_t>(PatchSearch<TypeParam>::patches(c.width)),
          CandidateRange{0, lanes_of(params)});
      this->run(pair, params, ranges, {0, c.height}, {left.view(), right.view()});
      const Plain plain(pair, params);
      for (int y = 0; y < c.height; ++y) {
        for (int x = 0; x < c.width; ++x) {
          ASSERT_EQ(left.view().at(x, y), plain.winner(x, y, ranges[0])) << c.width << " " << x;
          ASSERT_EQ(right.view().at(x, y), plain.right_winner(x, y)) << c.width << " " << x;
        }
      }
    }
  }
}

TYPED_TEST(Patches, EachPatchSearchesAtLeastItsOwnRange) {
  constexpr int kWidth = 4 * PatchSearch<TypeParam>::kPatchWidth + 5;
  Pair pair = noise(kWidth, 3, 8);
  const MatchParams params{{.disparities = 100, .block_width = 3, .block_height = 2}};
  const Plain plain(pair, params);
  const std::vector<CandidateRange> ranges{{0, 16}, {70, 32}, {75, 16}, {0, 112}, {37, 16}};
  Map left(kWidth, 3, kWidth);
  this->run(pair, params, ranges, {1, 3}, {left.view(), {}});
  for (int y = 1; y < 3; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const CandidateRange range =
          ranges[static_cast<std::size_t>(x / PatchSearch<TypeParam>::kPatchWidth)];
      const int found = left.view().at(x, y);
      const int own = plain.winner(x, y, range);
      if (own != kNoWinner) {
        ASSERT_TRUE(found != kNoWinner && plain.offered(x, found)) << x;
        ASSERT_LE(plain.cost(x, y, found), plain.cost(x, y, own)) << x;
      }
    }
  }
  EXPECT_LT(left.view().at(5, 1), 16);  // ranges this far apart are not searched as one
}

TEST(Pyramid, HalvesByTheRoundedMeanOfFourAndReplicatesTheBorder) {
  Picture in(3, 3, 3), out(2, 2, 2);
  const std::vector<std::uint8_t> values{1, 2, 9, 3, 5, 20, 100, 101, 250};
  for (std::size_t k = 0; k < values.size(); ++k) {
    in.view().row(static_cast<int>(k) / 3)[k % 3] = values[k];
  }
  halve(in.view(), out.view());
  EXPECT_EQ(out.view().at(0, 0), 3);    // (1 + 2 + 3 + 5 + 2) / 4
  EXPECT_EQ(out.view().at(1, 0), 15);   // (9 + 20 + 1) / 2
  EXPECT_EQ(out.view().at(0, 1), 101);  // 100.5
  EXPECT_EQ(out.view().at(1, 1), 250);
}

// A wall and, in its middle, a nearer board, each with its own patches of 4 x 4 px.
Pair wall_and_board(int width, int height, int wall, int board) {
  Pair pair(width, height);
  test::Random random(11);
  std::vector<std::uint8_t> patches(static_cast<std::size_t>(2 * width * height));
  random.fill(std::span<std::uint8_t>(patches));
  const auto texture = [&](int x, int y, bool on_board) {
    const int patch = (y / 4 * 2 + (on_board ? 1 : 0)) * width + (x + 100) / 4;
    return patches[static_cast<std::size_t>(patch)];
  };
  const auto on_board = [&](int x, int y) {
    return std::abs(2 * x - width) < width / 2 && std::abs(2 * y - height) < height / 2;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      pair.left.view().at(x, y) = texture(x, y, on_board(x, y));
      const bool meets_board = on_board(x + board, y);
      pair.right.view().at(x, y) = texture(x + (meets_board ? board : wall), y, meets_board);
    }
  }
  return pair;
}

void search(const MatchParams& params, const PyramidPictures& pictures,
            const PatchWinners& winners) {
  const int width = pictures.left.width();
  const int height = pictures.left.height();
  const bool check = !winners.right.empty();
  test::GuardedBuffer<std::byte> memory(bytes_taken(
      [&](Arena& measuring) { CoarseToFine(params, check, width, height, measuring); }));
  Arena arena(memory.span());
  CoarseToFine(params, check, width, height, arena).match(pictures, winners);
}

TEST(Pyramid, FindsNearAndFarFromEveryStartAndWithNegativeDisparities) {
  for (const int levels : {1, 2}) {
    for (const int min_disparity : {0, -31}) {
      const int wall = min_disparity + 6;
      const int board = min_disparity + 51;
      Pair pair = wall_and_board(240, 160, wall, board);
      MatchParams params{{.min_disparity = min_disparity,
                          .disparities = 61,
                          .block_width = 9,
                          .block_height = 9,
                          .prefilter_cap = std::nullopt}};
      params.pyramid_levels = levels;
      Map left(240, 160, 240), right(240, 160, 240);
      search(params, pair.pictures(), {left.view(), right.view()});
      int wrong = 0, count = 0;
      for (int y = 0; y < 160; ++y) {
        for (int x = 60; x < 200; ++x) {
          const bool deep_board = std::abs(x - 120) < 50 && std::abs(y - 80) < 30;
          const bool clear_wall = std::abs(y - 80) > 50;
          if (deep_board || clear_wall) {
            ++count;
            wrong += left.view().at(x, y) != (deep_board ? 51 : 6) ? 1 : 0;
          }
        }
      }
      EXPECT_LT(wrong * 100, count) << levels << " levels from " << min_disparity;
      const int met = 120 - board;
      EXPECT_EQ(right.view().at(met, 80), 51);
    }
  }
}

void expect_in_range(const MatchParams& params, ImageView<const std::int16_t> map) {
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      const int winner = map.at(x, y);
      const int column = x - params.min_disparity - winner;
      ASSERT_TRUE(winner == kNoWinner ||
                  (winner < params.disparities && column >= 0 && column < map.width()))
          << x;
    }
  }
}

struct Block {
  int width, height;
};

TEST(Pyramid, AnySizeStaysInsideItsMemoryAndItsRangeWithAnyVectors) {
  for (const Block block : {Block{7, 5}, Block{15, 15}, Block{16, 16}, Block{9, 8}}) {
    for (const int width : {1, 2, 3, 31, 48, 49, 100}) {
      for (const int height : {1, 2, 5, 32, 50}) {
        for (const int levels : {1, 2}) {
          Pair pair = noise(width, height, 5);
          for (const auto& picture : {pair.left.view(), pair.right.view()}) {
            for (int y = 0; y < height; ++y) {
              std::ranges::transform(picture.row(y), picture.row(y).begin(), [](std::uint8_t v) {
                return static_cast<std::uint8_t>(v * 3 / 4);  // of a derivative with a cap of 15
              });
            }
          }
          MatchParams params{{.min_disparity = -3,
                              .disparities = 37,
                              .block_width = block.width,
                              .block_height = block.height}};
          params.pyramid_levels = levels;
          Map expected(width, height, width);
          for (int level = 0; level <= static_cast<int>(widest_vectors()); ++level) {
            const UseVectors use(static_cast<Vectors>(level));
            Map left(width, height, width), right(width, height, width);
            for (const bool check : {true, false}) {
              search(params, pair.pictures(),
                     {left.view(), check ? right.view() : ImageView<std::int16_t>()});
              expect_in_range(params, left.view());
            }
            for (int y = 0; y < height; ++y) {
              if (level == 0) {
                std::ranges::copy(left.view().row(y), expected.view().row(y).begin());
              }
              ASSERT_TRUE(std::ranges::equal(left.view().row(y), expected.view().row(y)));
            }
          }
        }
      }
    }
  }
}

TEST(Pyramid, PixelsBetweenTakeAWinnerOfTheirNeighbours) {
  Pair pair = wall_and_board(240, 160, 6, 51);
  MatchParams params{{.disparities = 61, .block_width = 15, .block_height = 15}};
  params.pyramid_levels = 1;
  for (const auto& picture : {pair.left.view(), pair.right.view()}) {
    for (int y = 0; y < 160; ++y) {
      std::ranges::transform(picture.row(y), picture.row(y).begin(),
                             [](std::uint8_t v) { return static_cast<std::uint8_t>(v / 9); });
    }
  }
  Map map(240, 160, 240);
  search(params, pair.pictures(), {map.view(), {}});
  for (int y = 1; y < 159; y += 2) {
    for (int x = 61; x < 239; ++x) {
      const int winner = map.view().at(x, y);
      ASSERT_TRUE(winner == map.view().at(x, y - 1) || winner == map.view().at(x, y + 1)) << x;
      const int above = map.view().at(x, y - 1);
      const bool searched = x % 2 == 0;
      ASSERT_TRUE(searched || above == map.view().at(x - 1, y - 1) ||
                  above == map.view().at(x + 1, y - 1))
          << x;
    }
  }
}

TEST(Pyramid, FlatPictureHasNoWinner) {
  Pair pair(90, 60);
  MatchParams params;
  params.pyramid_levels = 2;
  Map left(90, 60, 90);
  search(params, pair.pictures(), {left.view(), {}});
  for (int y = 0; y < 60; ++y) {
    EXPECT_TRUE(std::ranges::all_of(left.view().row(y), [](int w) { return w == kNoWinner; }));
  }
}

// Percent of the visible pixels with truth that are missing or off by more than 1 px.
double bad_percent(const dataset::StereoScene& scene, ImageView<const std::int16_t> map) {
  int bad = 0, count = 0;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (scene.visible->view().at(x, y) != 0) {
        const float truth = scene.truth->view().at(x, y);
        const int winner = map.at(x, y);
        ++count;
        bad += winner == kNoWinner || std::abs(static_cast<float>(winner) - truth) > 1 ? 1 : 0;
      }
    }
  }
  return 100.0 * bad / count;
}

using PyramidOnRecordedScenes = test::RecordedScenes;
// Half a point of bad pixels on the four scenes that the reach of a level was chosen on, and in the
// mean of all; on a single other one up to 2.4 (Aloe: leaves of a few pixels are lost at a quarter
// of the size).
TEST_F(PyramidOnRecordedScenes, IsNotWorseThanTheFullSearch) {
  const std::set<std::string> chosen_on{"Cones", "Teddy", "Tsukuba", "Venus"};
  int scenes = 0;
  std::array<double, 3> sums{};  // of the full search, one level, two
  for (const auto& entry :
       std::filesystem::directory_iterator(test::recorded_scenes() / "stereo")) {
    if (!entry.is_directory()) {
      continue;
    }
    const dataset::Loaded<dataset::StereoScene> scene = dataset::read_stereo_scene(entry.path());
    ASSERT_TRUE(scene) << scene.error().message;
    const ImageView<const std::uint8_t> left = scene->left.view();
    const ImageView<const std::uint8_t> right = scene->right.view();
    Picture left_derivative(left.width(), left.height(), left.width());
    Picture right_derivative(left.width(), left.height(), left.width());
    for (int y = 0; y < left.height(); ++y) {
      best::clipped_sobel(left.row_clamped(y - 1), left.row(y), left.row_clamped(y + 1), 15,
                          left_derivative.view().row(y));
      best::clipped_sobel(right.row_clamped(y - 1), right.row(y), right.row_clamped(y + 1), 15,
                          right_derivative.view().row(y));
    }
    const auto bad_with = [&](std::optional<int> levels) {
      MatchParams params{{.disparities = scene->ndisp}};
      params.pyramid_levels = levels;
      Map map(left.width(), left.height(), left.width());
      search(params, {left_derivative.view(), right_derivative.view(), left, right},
             {map.view(), {}});
      return bad_percent(*scene, map.view());
    };
    const std::array<double, 3> bad{bad_with(std::nullopt), bad_with(1), bad_with(2)};
    const bool known = chosen_on.contains(scene->name);
    EXPECT_LT(bad[0], known ? 14 : 50) << scene->name;
    for (std::size_t levels = 0; levels < bad.size(); ++levels) {
      EXPECT_LT(bad[levels], bad[0] + (known ? 0.5 : 2.5)) << scene->name << " " << levels;
      sums[levels] += bad[levels];
    }
    ++scenes;
  }
  EXPECT_GE(scenes, 4);
  EXPECT_LT(sums[1], sums[0] + 0.5 * scenes);
  EXPECT_LT(sums[2], sums[0] + 0.5 * scenes);
}

}  // namespace
}  // namespace stof::lab

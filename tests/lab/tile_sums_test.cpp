#include "lab/pyramid/tile_sums.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "lab/pyramid/tile_strips.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

using Picture = test::GuardedImage<std::uint8_t>;
using Sums = test::GuardedBuffer<std::uint16_t>;

constexpr int kRows = 12;

Picture noise(int width, test::Random& random) {
  Picture picture(width, kRows, width);
  for (int y = 0; y < kRows; ++y) {
    random.fill(picture.view().row(y), 0, kLargestTilePixel);
  }
  return picture;
}

std::vector<std::vector<std::int16_t>> choices() {
  std::vector<std::vector<std::int16_t>> lists{{0}, {7}, {0, 9}, {3, 4, 5, 20, 21}};
  for (const int count : {7, 8, 9, 40}) {
    std::vector<std::int16_t>& list = lists.emplace_back();
    for (int i = 0; i < count; ++i) {
      list.push_back(static_cast<std::int16_t>(i + (i > 10 ? 3 : 0)));
    }
  }
  return lists;
}

TEST(TileSums, EqualTheReferenceForEveryBlockAndChoiceOfCandidates) {
  test::Random random(5);
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (int block = 1; block <= 64; ++block) {
      for (const auto& candidates : choices()) {
        const int last = candidates.back();
        const int height = std::min(kRows, kLargestTileSum / kLargestTilePixel / block);
        Picture left = noise(tile_reach(block) + 1, random);
        Picture right = noise(tile_reach(block) + last, random);
        const TilePlace tile{.left = left.view(),
                             .right = right.view(),
                             .left_x = 1,
                             .right_x = last,
                             .block_width = block,
                             .candidates = candidates};
        Sums expected(candidates.size() * kTileColumns);
        Sums sums(candidates.size() * kTileColumns);
        ref::start_tile(tile, {-2, height - 2}, expected.span());
        best::start_tile(tile, {-2, height - 2}, sums.span());
        for (std::size_t i = 0; i < sums.size(); ++i) {
          ASSERT_EQ(sums[i], expected[i]) << "block " << block << " at " << i;
        }
        for (int y = -2; y < 3; ++y) {
          ref::slide_tile(tile, y + height, y, expected.span());
          best::slide_tile(tile, y + height, y, sums.span());
        }
        for (std::size_t i = 0; i < sums.size(); ++i) {
          ASSERT_EQ(sums[i], expected[i]) << "block " << block << " at " << i;
        }
      }
    }
  }
}

// Few values, so that many tie.
Sums some_sums(std::size_t candidates, std::uint64_t seed) {
  test::Random random(seed);
  Sums sums(candidates * kTileColumns);
  std::vector<std::uint8_t> costs(sums.size());
  random.fill(std::span<std::uint8_t>(costs), 0, 3);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const std::size_t place = i / kTileColumns % kTileSumScale;
    sums[i] = static_cast<std::uint16_t>(kTileSumScale * costs[i] + place);
  }
  return sums;
}

TEST(TileSums, FindWhatTheReferenceFindsWithinAnyLimits) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (const auto& candidates : choices()) {
      for (const TileLimits limits : {TileLimits{-1100, 1100}, TileLimits{-40, 48},
                                      TileLimits{0, 60}, TileLimits{-3, 5}, TileLimits{90, 100}}) {
        for (const std::size_t width : {std::size_t{1}, std::size_t{17}, std::size_t{48}}) {
          Sums sums = some_sums(candidates.size(), width);
          test::GuardedBuffer<std::int16_t> expected(width, 99), found(width, 99);
          ref::find_in_tile(sums.span(), candidates, limits, expected.span());
          best::find_in_tile(sums.span(), candidates, limits, found.span());
          for (std::size_t x = 0; x < width; ++x) {
            ASSERT_EQ(found[x], expected[x]) << candidates.size() << " candidates at " << x;
          }
        }
      }
    }
  }
}

TEST(TileSums, OfferToTheRightWhatTheReferenceOffers) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (std::size_t n = 0; n <= 48; ++n) {
      test::GuardedBuffer<std::uint16_t> low(n, 2), expected_low(n, 2);
      test::GuardedBuffer<std::int16_t> won(n, -1), expected(n, -1);
      for (std::size_t i = 0; i < 3; ++i) {
        Sums sums = some_sums(1, n + i);
        const auto row = sums.span().first(n);
        ref::offer_to_right(row, static_cast<std::int16_t>(i), expected_low.span(),
                            expected.span());
        best::offer_to_right(row, static_cast<std::int16_t>(i), low.span(), won.span());
      }
      for (std::size_t x = 0; x < n; ++x) {
        ASSERT_EQ(low[x], expected_low[x]) << n;
        ASSERT_EQ(won[x], expected[x]) << n;
      }
    }
  }
}

// Columns and rows that replicate make ties of all candidates.
Picture half_flat(int width, test::Random& random) {
  Picture picture = noise(width, random);
  for (int y = 0; y < kRows; ++y) {
    const auto flat = picture.view().row(y).subspan(static_cast<std::size_t>(width) * 2 / 3);
    std::ranges::fill(flat, std::uint8_t{9});
  }
  return picture;
}

TEST(TileSums, FindAQuarterAsTheReferenceFindsItForEveryBlockAndLimit) {
  test::Random random(6);
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (const int block : {1, 2, 7, 8, 14, 15, 16, 17, 18, 31, 33, 64}) {
      for (const auto& candidates : choices()) {
        const int last = candidates.back();
        Picture left = half_flat(tile_reach(block) + 1, random);
        Picture right = half_flat(tile_reach(block) + last, random);
        const TilePlace tile{.left = left.view(),
                             .right = right.view(),
                             .left_x = 1,
                             .right_x = last,
                             .block_width = block,
                             .candidates = candidates};
        const int height = std::min(15, kLargestTileSum / kLargestTilePixel / block);
        for (const TileLimits limits : {TileLimits{-1100, 1100}, TileLimits{-40, 48},
                                        TileLimits{0, 60}, TileLimits{-3, 5}, TileLimits{90, 99}}) {
          for (const int rows : {1, 4, 2 * kQuarterRows}) {
            const int width = rows == 4 ? 7 : kQuarterColumns;
            const int found_rows = (rows + 1) / 2;
            test::GuardedImage<std::int16_t> expected(width, found_rows, width);
            test::GuardedImage<std::int16_t> found(width, found_rows, width);
            ref::find_quarter(tile, {-3, rows - 3}, height, limits, expected.view());
            best::find_quarter(tile, {-3, rows - 3}, height, limits, found.view());
            for (int r = 0; r < found_rows; ++r) {
              for (int k = 0; k < width; ++k) {
                ASSERT_EQ(found.view().at(k, r), expected.view().at(k, r))
                    << "block " << block << ", " << candidates.size() << " candidates at " << k;
              }
            }
          }
        }
      }
    }
  }
}

TEST(TileStrips, SearchingAQuarterIsEverySecondPixelOfSearchingAll) {
  test::Random random(10);
  for (const int width : {1, 2, 47, 49, 150}) {
    for (const int min_disparity : {-70, -3, 9}) {
      const lab::MatchParams params{{.min_disparity = min_disparity,
                                     .disparities = 21,
                                     .block_width = 15,
                                     .block_height = 8}};
      Picture left = noise(width, random), right = noise(width, random);
      test::GuardedBuffer<std::byte> memory(bytes_taken(
          [&](Arena& measuring) { lab::TileStrips(params, false, width, kRows, measuring); }));
      Arena arena(memory.span());
      lab::TileStrips strips(params, false, width, kRows, arena);
      strips.start(left.view(), right.view());
      using Map = test::GuardedImage<std::int16_t>;
      Map all(width, kRows, width), quarter((width + 1) / 2, kRows / 2, (width + 1) / 2);
      const std::vector<std::int16_t> candidates{0, 1, 2, 5, 6, 13, 20};
      for (int t = 0; t < lab::TileStrips::tiles(width); ++t) {
        strips.search({0, kRows}, t, candidates, {all.view(), {}});
        strips.search_quarter({0, 4}, t, candidates, quarter.view());
        strips.search_quarter({4, kRows}, t, candidates, quarter.view());
      }
      for (int r = 0; r < kRows / 2; ++r) {
        for (int k = 0; k < (width + 1) / 2; ++k) {
          ASSERT_EQ(quarter.view().at(k, r), all.view().at(2 * k, 2 * r)) << width << " " << k;
        }
      }
    }
  }
}

TEST(TileStrips, SearchingEverythingIsWhatTileSearchFinds) {
  test::Random random(9);
  for (const int width : {1, 40, 48, 49, 150}) {
    for (const int min_disparity : {-70, -3, 0, 9, 200}) {
      const lab::MatchParams params{
          {.min_disparity = min_disparity, .disparities = 37, .block_width = 7, .block_height = 5}};
      Picture left = noise(width, random), right = noise(width, random);
      const auto run = [&]<typename Search>(auto search_all) {
        test::GuardedBuffer<std::byte> memory(
            bytes_taken([&](Arena& measuring) { Search(params, true, width, kRows, measuring); }));
        Arena arena(memory.span());
        Search search(params, true, width, kRows, arena);
        search.start(left.view(), right.view());
        search_all(search);
      };
      using Map = test::GuardedImage<std::int16_t>;
      Map found(width, kRows, width), met(width, kRows, width);
      Map expected(width, kRows, width), expected_met(width, kRows, width);
      std::vector<std::int16_t> all(37);
      for (std::size_t i = 0; i < all.size(); ++i) {
        all[i] = static_cast<std::int16_t>(i);
      }
      run.template operator()<lab::TileStrips>([&](lab::TileStrips& strips) {
        for (int t = 0; t < lab::TileStrips::tiles(width); ++t) {
          strips.search({0, kRows}, t, all, {found.view(), met.view()});
        }
      });
      using Plain = lab::TileSearch<std::uint16_t>;
      run.template operator()<Plain>([&](Plain& search) {
        const std::vector<lab::CandidateRange> ranges(static_cast<std::size_t>(Plain::tiles(width)),
                                                      lab::CandidateRange{0, 48});
        search.search({0, kRows}, ranges, {expected.view(), expected_met.view()});
      });
      for (int y = 0; y < kRows; ++y) {
        for (int x = 0; x < width; ++x) {
          ASSERT_EQ(found.view().at(x, y), expected.view().at(x, y)) << width << " " << x;
          ASSERT_EQ(met.view().at(x, y), expected_met.view().at(x, y)) << width << " " << x;
        }
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp

#include "lab/pyramid/patch_sums.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "lab/pyramid/patch_strips.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

using Picture = test::GuardedImage<std::uint8_t>;

constexpr int kRows = 12;

Picture noise(int width, test::Random& random) {
  Picture picture(width, kRows, width);
  for (int y = 0; y < kRows; ++y) {
    random.fill(picture.view().row(y), 0, kLargestPatchPixel);
  }
  return picture;
}

constexpr std::array<std::size_t, 12> kBlocks{1, 2, 7, 8, 14, 15, 16, 17, 18, 31, 33, 64};

// half_flat: columns that replicate make ties of all candidates.
dsp::ImageView<std::uint8_t> noise(test::KernelCase& c, int width, bool half_flat) {
  const auto picture = c.image<std::uint8_t>(width, kRows);
  for (int y = 0; y < kRows; ++y) {
    c.fill(picture.row(y), 0, kLargestPatchPixel);
    if (half_flat) {
      std::ranges::fill(picture.row(y).subspan(static_cast<std::size_t>(width) * 2 / 3),
                        std::uint8_t{9});
    }
  }
  return picture;
}

PatchPlace place(test::KernelCase& c, int block, std::span<const std::int16_t> candidates,
                 bool half_flat) {
  const int last = candidates.back();
  return {.left = noise(c, patch_reach(block) + 1, half_flat),
          .right = noise(c, patch_reach(block) + last, half_flat),
          .left_x = 1,
          .right_x = last,
          .block_width = block,
          .candidates = candidates};
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

TEST(PatchSums, EqualReferenceForEveryBlockAndChoiceOfCandidates) {
  for (const auto& candidates : choices()) {
    test::check_kernel(kBlocks, [&](test::KernelCase& c) {
      const int block = static_cast<int>(c.length());
      const int height = std::min(kRows, kLargestPatchSum / kLargestPatchPixel / block);
      const PatchPlace patch = place(c, block, candidates, false);
      const auto started = c.array<std::uint16_t>(candidates.size() * kPatchColumns);
      c.run([&] { best::start_patch(patch, {-2, height - 2}, started); });
      const auto slid = c.array<std::uint16_t>(candidates.size() * kPatchColumns);
      std::ranges::copy(started, slid.begin());
      c.run([&] {
        for (int y = -2; y < 3; ++y) {
          best::slide_patch(patch, y + height, y, slid);
        }
      });
    });
  }
}

// Few values, so that many tie.
std::span<std::uint16_t> some_sums(test::KernelCase& c, std::size_t count) {
  const auto sums = c.array<std::uint16_t>(count, 0, 3);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i / kPatchColumns % kPatchSumScale;
    sums[i] = static_cast<std::uint16_t>(kPatchSumScale * sums[i] + at);
  }
  return sums;
}

TEST(PatchSums, FoundInAPatchEqualsReferenceWithinAnyLimits) {
  for (const auto& candidates : choices()) {
    for (const PatchLimits limits :
         {PatchLimits{-1100, 1100}, PatchLimits{-40, 48}, PatchLimits{0, 60}, PatchLimits{-3, 5},
          PatchLimits{90, 100}}) {
      test::check_kernel(std::array<std::size_t, 3>{1, 17, 48}, [&](test::KernelCase& c) {
        const auto sums = some_sums(c, candidates.size() * kPatchColumns);
        const auto winners = c.array<std::int16_t>(c.length());
        c.run([&] { best::find_in_patch(sums, candidates, limits, winners); });
      });
    }
  }
}

TEST(PatchSums, OfferedToTheRightEqualsReference) {
  test::check_kernel(std::array<std::size_t, 9>{0, 1, 7, 8, 15, 16, 17, 33, 48},
                     [](test::KernelCase& c) {
                       const auto lowest = c.array<std::uint16_t>(c.length(), 2, 2);
                       const auto winners = c.array<std::int16_t>(c.length(), -1, -1);
                       for (std::int16_t i = 0; i < 3; ++i) {
                         const auto sums = some_sums(c, c.length());
                         c.run([&] { best::offer_to_right(sums, i, lowest, winners); });
                       }
                     });
}

TEST(PatchSums, AQuarterEqualsReferenceForEveryBlockAndLimit) {
  for (const auto& candidates : choices()) {
    for (const PatchLimits limits : {PatchLimits{-1100, 1100}, PatchLimits{-40, 48},
                                     PatchLimits{0, 60}, PatchLimits{-3, 5}, PatchLimits{90, 99}}) {
      for (const int rows : {1, 4, 2 * kQuarterRows}) {
        test::check_kernel(kBlocks, [&](test::KernelCase& c) {
          const int block = static_cast<int>(c.length());
          const int height = std::min(15, kLargestPatchSum / kLargestPatchPixel / block);
          const PatchPlace patch = place(c, block, candidates, true);
          const auto found = c.image<std::int16_t>(rows == 4 ? 7 : kQuarterColumns, (rows + 1) / 2);
          c.run([&] { best::find_quarter(patch, {-3, rows - 3}, height, limits, found); });
        });
      }
    }
  }
}

TEST(PatchStrips, SearchingAQuarterIsEverySecondPixelOfSearchingAll) {
  test::Random random(10);
  for (const int width : {1, 2, 47, 49, 150}) {
    for (const int min_disparity : {-70, -3, 9}) {
      const lab::MatchParams params{{.min_disparity = min_disparity,
                                     .disparities = 21,
                                     .block_width = 15,
                                     .block_height = 8}};
      Picture left = noise(width, random), right = noise(width, random);
      test::GuardedBuffer<std::byte> memory(bytes_taken(
          [&](Arena& measuring) { lab::PatchStrips(params, false, width, kRows, measuring); }));
      Arena arena(memory.span());
      lab::PatchStrips strips(params, false, width, kRows, arena);
      strips.start(left.view(), right.view());
      using Map = test::GuardedImage<std::int16_t>;
      Map all(width, kRows, width), quarter((width + 1) / 2, kRows / 2, (width + 1) / 2);
      const std::vector<std::int16_t> candidates{0, 1, 2, 5, 6, 13, 20};
      for (int t = 0; t < lab::PatchStrips::patches(width); ++t) {
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

TEST(PatchStrips, SearchingEverythingIsWhatPatchSearchFinds) {
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
      run.template operator()<lab::PatchStrips>([&](lab::PatchStrips& strips) {
        for (int t = 0; t < lab::PatchStrips::patches(width); ++t) {
          strips.search({0, kRows}, t, all, {found.view(), met.view()});
        }
      });
      using Plain = lab::PatchSearch<std::uint16_t>;
      run.template operator()<Plain>([&](Plain& search) {
        const std::vector<lab::CandidateRange> ranges(
            static_cast<std::size_t>(Plain::patches(width)), lab::CandidateRange{0, 48});
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

#include "dsp/pmd/phase/merge_exposures.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

// A row of pixels that owns its memory; ratio and sigma where `all` says so.
struct Row {
  explicit Row(std::size_t n, bool all = true)
      : phase(n), amp2(n), offset(n), ratio(all ? n : 0), sigma(all ? n : 0), flags(n) {}
  ExposureRow spans() {
    return {.phase = phase.span(),
            .amp2 = amp2.span(),
            .offset = offset.span(),
            .ratio = ratio.span(),
            .sigma = sigma.span(),
            .flags = flags.span()};
  }
  void fill(test::Random& random) {
    random.fill(phase.span());
    random.fill(amp2.span());
    random.fill(offset.span());
    random.fill(ratio.span());
    random.fill(sigma.span());
    for (std::uint8_t& flag : flags.span()) {
      flag = random.between(0, 1) == 0 ? static_cast<std::uint8_t>(random.next()) : 0;
    }
  }
  void copy(const Row& from) {
    std::ranges::copy(from.phase.span(), phase.span().begin());
    std::ranges::copy(from.amp2.span(), amp2.span().begin());
    std::ranges::copy(from.offset.span(), offset.span().begin());
    std::ranges::copy(from.ratio.span(), ratio.span().begin());
    std::ranges::copy(from.sigma.span(), sigma.span().begin());
    std::ranges::copy(from.flags.span(), flags.span().begin());
  }
  // Pixel x as one tuple.
  auto at(std::size_t x) {
    return std::tuple(phase[x], amp2[x], offset[x], ratio[x], sigma[x], flags[x]);
  }

  test::GuardedBuffer<Phase> phase;
  test::GuardedBuffer<std::uint16_t> amp2, offset;
  test::GuardedBuffer<std::uint8_t> ratio;
  test::GuardedBuffer<QuarterMm> sigma;
  test::GuardedBuffer<std::uint8_t> flags;
};

TEST(MergeExposures, TakesTheLongestThatIsNotSaturated) {
  // All eight patterns of "saturated" in three exposures, the longest first.
  constexpr std::array<std::uint8_t, 8> kTaken{0, 1, 0, 2, 0, 1, 0, 2};
  std::vector<Row> exposures;
  test::Random random(1);
  for (std::size_t k = 0; k < 3; ++k) {
    Row& row = exposures.emplace_back(8);
    row.fill(random);
    for (std::size_t x = 0; x < 8; ++x) {
      row.flags[x] = (x >> k & 1) != 0 ? kPmdSaturated | kPmdAsymmetric : kPmdLowRatio;
    }
  }
  Row merged(8);
  merged.copy(exposures[0]);
  std::vector<std::uint8_t> taken(8, 0);
  best::merge_exposures(exposures[1].spans(), 1, kUnchangedQ8, merged.spans(), taken);
  best::merge_exposures(exposures[2].spans(), 2, kUnchangedQ8, merged.spans(), taken);
  EXPECT_TRUE(std::ranges::equal(taken, kTaken));
  for (std::size_t x = 0; x < 8; ++x) {
    EXPECT_EQ(merged.at(x), exposures[kTaken[x]].at(x)) << x;
  }
  EXPECT_EQ(merged.flags[7], kPmdSaturated | kPmdAsymmetric);  // all are: the shortest one's flags
}

TEST(MergeExposures, BringsAmplitudesToTheLongestExposureWhereAsked) {
  Row shorter(1), merged(1);
  shorter.amp2[0] = 1001;
  shorter.offset[0] = 9000;
  shorter.sigma[0] = 77;
  merged.flags[0] = kPmdSaturated;
  std::vector<std::uint8_t> taken(1, 0);
  best::merge_exposures(shorter.spans(), 1, 2176, merged.spans(), taken);  // 8.5 times
  EXPECT_EQ(merged.amp2[0], 8509);                                         // 8508.5
  EXPECT_EQ(merged.offset[0], 65535);
  EXPECT_EQ(merged.sigma[0], 77);
}

TEST(MergeExposures, EqualsReferenceForEveryLengthAndExtreme) {
  for (const bool all : {false, true}) {
    for (const int gain : {0, 2176, 65535}) {
      test::check_kernel([&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const auto row = [&] {
          ExposureRow made{.phase = c.array<Phase>(n),
                           .amp2 = c.array<std::uint16_t>(n, 0, 65535),
                           .offset = c.array<std::uint16_t>(n, 0, 65535),
                           .ratio = c.array<std::uint8_t>(all ? n : 0),
                           .sigma = c.array<QuarterMm>(all ? n : 0),
                           .flags = c.array<std::uint8_t>(n)};
          for (std::uint8_t& flag : made.flags) {
            flag = c.random().between(0, 1) == 0 ? flag : std::uint8_t{0};
          }
          return made;
        };
        const ExposureRow shorter = row(), merged = row();
        const auto taken = c.array<std::uint8_t>(n, 3, 3);
        c.run([&] {
          best::merge_exposures(shorter, 7, static_cast<std::uint16_t>(gain), merged, taken);
        });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp

#include "dsp/pmd/range/combine_frequencies.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "dsp/calib/pmd/frequency_pair.h"
#include "dsp/pmd/pmd_maps.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr std::array<std::array<std::uint32_t, 2>, 6> kPairs{{{20'000'000, 18'750'000},
                                                              {60'000'000, 50'000'000},
                                                              {20'000'000, 15'000'000},
                                                              {60'000'000, 20'000'000},
                                                              {64'000'000, 63'000'000},
                                                              {1'280'000, 1'260'000}}};

struct Reading {
  std::uint32_t distance;
  int flags;
  friend bool operator==(const Reading&, const Reading&) = default;
};

struct Pixel {
  Phase phi1 = 0;
  Phase phi2 = 0;
  std::uint16_t amp1 = 1000;
  std::uint16_t amp2 = 1000;
  std::uint8_t flags1 = 0;
  std::uint8_t flags2 = 0;
};

Reading run(const FrequencyPair& pair, Pixel p, std::span<const QuarterMm> sigma1 = {},
            std::span<const QuarterMm> sigma2 = {}) {
  std::uint32_t distance = 0;
  best::combine_frequencies({{&p.phi1, 1}, {&p.amp1, 1}, sigma1},
                            {{&p.phi2, 1}, {&p.amp2, 1}, sigma2}, pair, {&p.flags2, 1},
                            {&p.flags1, 1}, {&distance, 1});
  return {distance, p.flags1};
}

FrequencyPair pair_of(const std::array<std::uint32_t, 2>& hertz) {
  return make_frequency_pair(Hertz{hertz[0]}, Hertz{hertz[1]});
}

// Turns of a frequency at a distance.
double turns_at(double metres, std::uint32_t hertz) { return metres * 2 * hertz / 299792458.0; }

Phase phase_at(double metres, std::uint32_t hertz) {
  return static_cast<Phase>(std::lround(turns_at(metres, hertz) * 65536) & 0xFFFF);
}

TEST(CombineFrequencies, TellsTwentyAndEighteenAndThreeQuarterMegahertzApartUpTo120Metres) {
  const FrequencyPair pair = pair_of(kPairs[0]);
  EXPECT_EQ(pair.m, 16U);
  EXPECT_EQ(pair.n, 15U);
  EXPECT_EQ(pair.inverse, 15U);
  EXPECT_EQ(common_range(pair), 1'199'170U);  // 119.917 m
  // 34 m: 4.5365 turns of 20 MHz and 4.2530 of 18.75 MHz.
  EXPECT_NEAR(run(pair, {.phi1 = 35'160, .phi2 = 16'578}).distance, 340'000, 2);
}

TEST(CombineFrequencies, GivesBackEveryDistanceOfTheRange) {
  for (const std::array<std::uint32_t, 2>& hertz : kPairs) {
    const FrequencyPair pair = pair_of(hertz);
    const double range = common_range(pair) / 10000.0;
    for (int i = 0; i < 4000; ++i) {
      const double metres = range * (i + 0.5) / 4000;
      const Reading reading =
          run(pair, {.phi1 = phase_at(metres, hertz[0]), .phi2 = phase_at(metres, hertz[1])});
      // Half a phase unit of each frequency, a sixteenth of the correction, half a unit of
      // distance.
      const double tolerance = 0.57 * 1e4 * 299792458.0 / 2 / hertz[1] / 65536 + 0.51;
      ASSERT_NEAR(reading.distance, metres * 1e4, tolerance) << hertz[0] << " at " << metres;
      ASSERT_EQ(reading.flags, 0);
    }
  }
}

TEST(CombineFrequencies, WeighsBothEstimatesByTheSquareOfFrequencyTimesAmplitude) {
  const std::array<std::uint32_t, 2> hertz{20'000'000, 15'000'000};
  const FrequencyPair pair = pair_of(hertz);
  // The frequencies read 10.00 m and 10.06 m.
  const Phase phi1 = phase_at(10.00, hertz[0]);
  const Phase phi2 = phase_at(10.06, hertz[1]);
  for (const int amp2 : {0, 100, 1000, 3000, 65535}) {
    const double a = 20.0 * 1000;
    const double b = 15.0 * amp2;
    const double want = (a * a * 10.00 + b * b * 10.06) / (a * a + b * b);
    const Reading reading =
        run(pair, {.phi1 = phi1, .phi2 = phi2, .amp2 = static_cast<std::uint16_t>(amp2)});
    EXPECT_NEAR(reading.distance, want * 1e4, 2.5) << amp2;
  }
  EXPECT_NEAR(run(pair, {.phi1 = phi1, .phi2 = phi2, .amp1 = 0, .amp2 = 0}).distance, 100'000, 2.5);
}

TEST(CombineFrequencies, WrapsAsAWholeAtBothEndsOfTheRange) {
  const FrequencyPair pair = pair_of(kPairs[0]);
  const std::uint32_t range = common_range(pair);
  // 3 units before 0 in one frequency, 3 behind it in the other: the mean is 0, whichever comes
  // first.
  for (const int side : {-3, 3}) {
    const Reading reading =
        run(pair, {.phi1 = static_cast<Phase>(side), .phi2 = static_cast<Phase>(-side)});
    EXPECT_EQ(reading.flags, 0);
    EXPECT_LE(std::min(reading.distance, range - reading.distance), 3U) << side;
  }
  EXPECT_EQ(run(pair, {}).distance, 1U);  // 0 means none
  EXPECT_EQ(run(pair, {.phi1 = 65535, .phi2 = 65535}).distance, range - 1);
}

TEST(CombineFrequencies, RefusesPhasesThatContradictEachOther) {
  FrequencyPair pair = pair_of(kPairs[0]);
  // A turn of the beat is 65536 / 15 units of the first phase at constant second phase.
  const Phase phi1 = phase_at(34, 20'000'000);
  const Phase phi2 = phase_at(34, 18'750'000);
  const auto moved = [&](int units) {
    return run(pair, {.phi1 = static_cast<Phase>(phi1 + units), .phi2 = phi2});
  };
  for (const int sign : {-1, 1}) {
    EXPECT_EQ(moved(sign * 1080).flags, 0);
    EXPECT_EQ(moved(sign * 1105), (Reading{0, kPmdWrapped}));
  }
  pair.tolerance = 8192;
  EXPECT_EQ(moved(540).flags, 0);
  EXPECT_EQ(moved(560), (Reading{0, kPmdWrapped}));
  pair.tolerance = 32768;
  EXPECT_EQ(moved(2000).flags, 0);
}

TEST(CombineFrequencies, RefusesNoiseThatCouldAgreeByChance) {
  const FrequencyPair pair = pair_of(kPairs[0]);
  // 0.15 turns of the beat are 0.15 / 15 turns of 20 MHz: 299.8 quarter mm.
  EXPECT_NEAR(std::sqrt(pair.max_variance), 299.8, 0.1);
  const QuarterMm good = 211;
  const QuarterMm poor = 214;
  EXPECT_EQ(run(pair, {}, {&good, 1}, {&good, 1}).flags, 0);
  EXPECT_EQ(run(pair, {}, {&good, 1}, {&poor, 1}), (Reading{0, kPmdWrapped}));
  const QuarterMm most = 65535;
  EXPECT_EQ(run(pair, {}, {&most, 1}, {&most, 1}), (Reading{0, kPmdWrapped}));
}

TEST(CombineFrequencies, AWrongTurnNeverAgreesAtTheNoiseThatIsAccepted) {
  for (const std::array<std::uint32_t, 2>& hertz : kPairs) {
    const FrequencyPair pair = pair_of(hertz);
    const double range = common_range(pair) / 10000.0;
    test::Random random(hertz[0]);
    // Four standard deviations of the difference, all of it in one frequency or shared out.
    const double difference = 4 * std::sqrt(pair.max_variance) / 4000;
    for (int i = 0; i < 2000; ++i) {
      const double metres = range * random.between(100, 9900) / 10000;
      const double share = random.between(0, 10) / 10.0;
      const double sign = random.between(0, 1) == 0 ? 1 : -1;
      const double first = metres + sign * share * difference;
      const double second = metres - sign * (1 - share) * difference;
      const Reading reading =
          run(pair, {.phi1 = phase_at(first, hertz[0]), .phi2 = phase_at(second, hertz[1])});
      ASSERT_TRUE((reading.flags & kPmdWrapped) != 0 ||
                  std::abs(reading.distance / 1e4 - metres) <= difference + 0.001)
          << hertz[0] << " at " << metres << " reads " << reading.distance;
    }
  }
}

TEST(CombineFrequencies, LeavesOutWhatEitherFrequencyCannotTell) {
  const FrequencyPair pair = pair_of(kPairs[0]);
  for (int bit = 0; bit < 8; ++bit) {
    const std::uint8_t flag = static_cast<std::uint8_t>(1 << bit);
    const bool missing = (flag & kPmdMissing) != 0;
    const Reading first = run(pair, {.phi1 = 16000, .phi2 = 15000, .flags1 = flag});
    const Reading second = run(pair, {.phi1 = 16000, .phi2 = 15000, .flags2 = flag});
    EXPECT_EQ(first.distance == 0, missing) << bit;
    EXPECT_EQ(first, second) << bit;
    EXPECT_EQ(first.flags, flag);
  }
}

TEST(FrequencyPair, IsUsableInLowestTermsUpTo64) {
  for (const std::array<std::uint32_t, 2>& hertz : kPairs) {
    EXPECT_TRUE(usable_pair(Hertz{hertz[0]}, Hertz{hertz[1]})) << hertz[0];
    EXPECT_FALSE(usable_pair(Hertz{hertz[1]}, Hertz{hertz[0]})) << hertz[0];
  }
  EXPECT_FALSE(usable_pair(Hertz{20'000'000}, Hertz{20'000'000}));
  EXPECT_FALSE(usable_pair(Hertz{20'000'000}, Hertz{19'990'000}));
  EXPECT_FALSE(usable_pair(Hertz{20'000'000}, Hertz{0}));
  EXPECT_FALSE(usable_pair(Hertz{65'000'000}, Hertz{64'000'000}));
}

TEST(CombineFrequencies, EqualsReferenceForEveryLengthAndExtreme) {
  for (int variant = 0; variant < 10; ++variant) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length(), with_sigma = variant % 2 == 0 ? n : 0;
      const auto phi1 = c.array<Phase>(n), phi2 = c.array<Phase>(n);
      const auto amp1 = c.array<std::uint16_t>(n, 0, variant < 2 ? 2 : 65535);
      const auto amp2 = c.array<std::uint16_t>(n, 0, variant < 4 ? 2 : 65535);
      const auto sigma1 = c.array<QuarterMm>(with_sigma, 1, variant < 6 ? 300 : 65535);
      const auto sigma2 = c.array<QuarterMm>(with_sigma, 1, variant < 6 ? 300 : 65535);
      const auto other = c.array<std::uint8_t>(n), flags = c.array<std::uint8_t>(n);
      test::Random& random = c.random();
      for (std::size_t x = 0; x < n; ++x) {  // the borders of q and of the range
        phi1[x] = random.between(0, 3) == 0 ? static_cast<Phase>(random.between(-3, 3)) : phi1[x];
        phi2[x] = random.between(0, 3) == 0 ? static_cast<Phase>(random.between(-3, 3)) : phi2[x];
        other[x] = random.between(0, 7) == 0 ? other[x] : std::uint8_t{0};
        flags[x] = random.between(0, 7) == 0 ? flags[x] : std::uint8_t{0};
      }
      FrequencyPair pair;
      pair.m = static_cast<std::uint32_t>(random.between(2, static_cast<int>(kMostTurns)));
      pair.n = static_cast<std::uint32_t>(random.between(1, static_cast<int>(pair.m) - 1));
      pair.inverse = static_cast<std::uint32_t>(random.between(0, static_cast<int>(pair.m) - 1));
      pair.turn_q11 = variant == 9 ? ~0U : static_cast<std::uint32_t>(random.next());
      pair.tolerance = static_cast<std::uint32_t>(random.between(0, 32768));
      pair.max_variance = variant == 8 ? ~0U : static_cast<std::uint32_t>(random.between(0, 90000));
      const auto distance = c.array<std::uint32_t>(n);
      c.run([&] {
        best::combine_frequencies({phi1, amp1, sigma1}, {phi2, amp2, sigma2}, pair, other, flags,
                                  distance);
      });
    });
  }
}

}  // namespace
}  // namespace stof::dsp

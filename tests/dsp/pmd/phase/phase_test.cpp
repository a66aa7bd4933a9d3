#include "dsp/pmd/phase/phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

struct Pixel {
  int phase;
  int amp2;
  int offset;
  int flags;
  friend bool operator==(const Pixel&, const Pixel&) = default;
};

Pixel run(std::array<std::uint16_t, 4> a, const PhaseLimits& limits = {}) {
  Phase phase = 0;
  std::uint16_t amp2 = 0;
  std::uint16_t offset = 0;
  std::uint8_t flags = 0;
  const auto one = [](const std::uint16_t& sample) { return std::span(&sample, 1); };
  best::phase({one(a[0]), one(a[1]), one(a[2]), one(a[3])}, limits,
              {{&phase, 1}, {&amp2, 1}, {&offset, 1}, {&flags, 1}});
  return {phase, amp2, offset, flags};
}

// What both variants make of n pixels, in guarded memory.
struct Outputs {
  explicit Outputs(std::size_t n) : phase(n), amp2(n), offset(n), flags(n) {}
  PhaseRow row() { return {phase.span(), amp2.span(), offset.span(), flags.span()}; }
  test::GuardedBuffer<Phase> phase;
  test::GuardedBuffer<std::uint16_t> amp2;
  test::GuardedBuffer<std::uint16_t> offset;
  test::GuardedBuffer<std::uint8_t> flags;
};

struct Samples {
  explicit Samples(std::size_t n) : a{buffer(n), buffer(n), buffer(n), buffer(n)} {}
  static test::GuardedBuffer<std::uint16_t> buffer(std::size_t n) {
    return test::GuardedBuffer<std::uint16_t>(n);
  }
  SampleRows rows() { return {a[0].span(), a[1].span(), a[2].span(), a[3].span()}; }
  std::array<test::GuardedBuffer<std::uint16_t>, 4> a;
};

TEST(Phase, OfTheFourAxesAndDiagonals) {
  const PhaseLimits limits{.dark = 300};
  EXPECT_EQ(run({1600, 1000, 1000, 1000}, limits), (Pixel{0, 600, 850, 0}));
  EXPECT_EQ(run({1000, 1000, 1000, 1600}, limits), (Pixel{16384, 600, 850, 0}));
  EXPECT_EQ(run({1000, 1000, 1600, 1000}, limits), (Pixel{32768, 600, 850, 0}));
  EXPECT_EQ(run({1000, 1600, 1000, 1000}, limits), (Pixel{49152, 600, 850, 0}));
  EXPECT_EQ(run({1300, 1000, 1000, 1300}).phase, 8192);
  EXPECT_EQ(run({1000, 1000, 1300, 1300}).phase, 24576);
  EXPECT_EQ(run({1000, 1300, 1300, 1000}).phase, 40960);
  EXPECT_EQ(run({1300, 1300, 1000, 1000}).phase, 57344);
  EXPECT_EQ(run({1300, 1000, 1000, 1400}).amp2, 500);  // 3-4-5
}

TEST(Phase, OfNoLightAtAllIsZeroAndLowAmplitude) {
  EXPECT_EQ(run({500, 500, 500, 500}), (Pixel{0, 0, 500, kPmdLowAmplitude | kPmdLowRatio}));
  EXPECT_EQ(run({0, 0, 0, 0}), (Pixel{0, 0, 0, kPmdUnderRange | kPmdLowAmplitude}));
}

TEST(Phase, FlagsSaturationAndUnderRangeOfAnySingleSample) {
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<std::uint16_t, 4> a{2000, 1500, 1000, 1500};
    a[k] = 4095;
    EXPECT_TRUE(run(a).flags & kPmdSaturated);
    a[k] = 4094;
    EXPECT_FALSE(run(a).flags & kPmdSaturated);
    a[k] = 0;
    EXPECT_TRUE(run(a).flags & kPmdUnderRange);
    a[k] = 1;
    EXPECT_FALSE(run(a).flags & kPmdUnderRange);
  }
}

TEST(Phase, KeepsThirtyPercentModulationAndFlagsLess) {
  const PhaseLimits limits{.dark = 100};
  // offset 1000 needs amp2 >= 39322 * 1000 >> 16 = 600, that is A = 300.
  EXPECT_EQ(run({1400, 1100, 800, 1100}, limits).flags, 0);
  EXPECT_EQ(run({1400, 1100, 801, 1100}, limits).flags, kPmdLowRatio);
}

TEST(Phase, SubtractsStrayLightBeforePhaseAndAmplitude) {
  // I = 600 of which 500 are stray light, Q = -120 of which -220 are: 45 degrees, sqrt(2) 100.
  const PhaseLimits limits{.min_amp2 = 0, .ratio_q16 = 0, .stray_i = 500, .stray_q = -220};
  EXPECT_EQ(run({1300, 1060, 700, 940}, limits), (Pixel{8192, 141, 1000, 0}));
  // Stray light alone is no light.
  EXPECT_EQ(run({1250, 1110, 750, 890}, limits), (Pixel{0, 0, 1000, 0}));
  // The chapter's limit of 30 percent is that of what remains.
  EXPECT_EQ(run({1300, 1060, 700, 940}, {.stray_i = 500, .stray_q = -220}).flags, kPmdLowRatio);
}

TEST(Phase, LimitsWhatIsLeftOfStrayLightToSixteenBits) {
  const PhaseLimits limits{.saturation = 65535, .stray_i = -32767, .stray_q = 32767};
  const Pixel most = run({32767, 32767, 0, 0}, limits);  // I = 65534, Q = -65534 if they fitted
  EXPECT_EQ(most.phase, 57344);
  EXPECT_EQ(most.amp2, 46340);
}

TEST(Phase, ClampsTheOffsetAtDark) {
  EXPECT_EQ(run({110, 100, 90, 100}, {.dark = 100}).offset, 0);
  EXPECT_EQ(run({110, 100, 90, 100}, {.dark = 60000}).offset, 0);
  EXPECT_EQ(run({111, 100, 90, 101}, {.dark = 99}).offset, 2);  // (402 + 2) / 4 = 101
}

TEST(Phase, FlagsUnevenSamplesAboveTheirNoise) {
  const PhaseLimits limits{.asymmetry_base = 400, .asymmetry_slope_q8 = 256};
  // offset 1000: limit 1400, so a difference of 37 is noise and 38 is not.
  EXPECT_EQ(run({1337, 1000, 700, 1000}, limits).flags, 0);
  EXPECT_EQ(run({1338, 1000, 700, 1000}, limits).flags, kPmdAsymmetric);
  EXPECT_EQ(run({1338, 1000, 700, 1000}, {}).flags, 0);  // without a limit
}

TEST(Phase, TakesSixteenBitSamplesAsTheLargestFifteenBitOnes) {
  EXPECT_EQ(run({65535, 0, 0, 0}), run({32767, 0, 0, 0}));
  EXPECT_EQ(run({65535, 65535, 65535, 65535}).offset, 32767);
}

double phase_error(Phase phase, int i, int q) {
  const double exact = std::atan2(q, i) / (2 * std::numbers::pi) * 65536;
  return std::abs(std::remainder(phase - exact, 65536.0));
}

// Largest error of the phase; counts amplitudes that are not the rounded root.
struct Accuracy {
  double phase = 0;
  int wrong_roots = 0;
};

void judge(Samples& samples, const PhaseLimits& limits, Accuracy& worst) {
  const std::size_t n = samples.a[0].size();
  Outputs out(n);
  best::phase(samples.rows(), limits, out.row());
  for (std::size_t x = 0; x < n; ++x) {
    const int i = samples.a[0][x] - samples.a[2][x] - limits.stray_i;
    const int q = samples.a[3][x] - samples.a[1][x] - limits.stray_q;
    worst.wrong_roots += out.amp2[x] != std::lround(std::sqrt(1.0 * i * i + 1.0 * q * q));
    if (i != 0 || q != 0) {
      worst.phase = std::max(worst.phase, phase_error(out.phase[x], i, q));
    }
  }
}

TEST(Phase, StaysWithinOneLsbOfDoubleOnFourMillionRandomSamples) {
  constexpr std::size_t kPixels = 8000;
  constexpr std::uint64_t kSeed = 20;
  test::Random random(kSeed);
  Samples samples(kPixels);
  Accuracy worst;
  for (int block = 0; block < 500; ++block) {
    const int top = (1 << random.between(10, 15)) - 1;
    // Half of the blocks have any amplitude, half a small one: a few LSB turn the phase far.
    const int swing = block % 2 == 0 ? top : std::min(1 << random.between(1, 12), top);
    const int low = random.between(0, top - swing);
    for (test::GuardedBuffer<std::uint16_t>& plane : samples.a) {
      random.fill(plane.span(), low, low + swing);
    }
    // Every third block with stray light of up to half the sensor.
    PhaseLimits limits;
    if (block % 3 == 0) {
      // I and Q stay within 16 bits: nothing is limited.
      const int most = std::min(top / 2, 32767 - swing);
      limits.stray_i = static_cast<std::int16_t>(random.between(-most, most));
      limits.stray_q = static_cast<std::int16_t>(random.between(-most, most));
    }
    judge(samples, limits, worst);
  }
  EXPECT_LE(worst.phase, 0.70) << "seed " << kSeed;
  EXPECT_EQ(worst.wrong_roots, 0) << "seed " << kSeed;
}

TEST(Phase, StaysWithinOneLsbOnEveryRatioOfTheLargestAmplitude) {
  constexpr std::size_t kPixels = 32768;
  Samples samples(kPixels);
  Accuracy worst;
  for (const bool steep : {false, true}) {
    for (std::size_t x = 0; x < kPixels; ++x) {
      samples.a[steep ? 3 : 0][x] = 32767;
      samples.a[steep ? 0 : 3][x] = static_cast<std::uint16_t>(x);
    }
    judge(samples, {}, worst);
  }
  EXPECT_LE(worst.phase, 0.70);
  EXPECT_EQ(worst.wrong_roots, 0);
}

// Four planes of random samples up to `top`, a few of them 0 or `top`.
SampleRows random_samples(test::KernelCase& c, int top) {
  SampleRows samples;
  for (std::span<const std::uint16_t>& plane : samples) {
    const auto drawn = c.array<std::uint16_t>(c.length(), 0, top);
    for (std::uint16_t& sample : drawn) {
      const int what = c.random().between(0, 15);
      sample = what <= 1 ? static_cast<std::uint16_t>(what * top) : sample;
    }
    plane = drawn;
  }
  return samples;
}

void run_kernel(test::KernelCase& c, const SampleRows& samples, const PhaseLimits& limits) {
  const std::size_t n = samples[0].size();
  const PhaseRow out{c.array<Phase>(n), c.array<std::uint16_t>(n), c.array<std::uint16_t>(n),
                     c.array<std::uint8_t>(n)};
  c.run([&] { best::phase(samples, limits, out); });
}

TEST(Phase, EqualsReferenceForEveryLengthAndExtreme) {
  for (const int top : {1, 255, 4095, 8191, 32767, 65535}) {
    for (const bool stray : {false, true}) {
      test::check_kernel([&](test::KernelCase& c) {
        PhaseLimits limits{
            .saturation = static_cast<std::uint16_t>(top),
            .lowest = static_cast<std::uint16_t>(c.draw(0, 1)),
            .dark = static_cast<std::uint16_t>(c.draw(0, 200)),
            .min_amp2 = static_cast<std::uint16_t>(c.draw(0, 300)),
            .ratio_q16 = static_cast<std::uint32_t>(c.draw(0, kMaxRatioQ16)),
            .asymmetry_base = static_cast<std::uint32_t>(c.random().next()) >> (c.length() % 32),
            .asymmetry_slope_q8 = static_cast<std::uint32_t>(c.draw(0, kMaxAsymmetrySlopeQ8))};
        if (stray) {
          limits.stray_i = static_cast<std::int16_t>(c.draw(-32767, 32767));
          limits.stray_q = static_cast<std::int16_t>(c.draw(-32767, 32767));
        }
        run_kernel(c, random_samples(c, top), limits);
      });
    }
  }
}

// Limits of the sizes that the ways of few bits are for, and next to them.
TEST(Phase, EqualsReferenceWhereFewBitsHoldEverything) {
  test::check_kernel_rounds(400, [](test::KernelCase& c) {
    const std::size_t n = c.length();
    test::Random& random = c.random();
    const int top = n % 2 == 0 ? 4095 : 8191;
    PhaseLimits limits{.saturation = static_cast<std::uint16_t>(top + random.between(-1, 1)),
                       .lowest = static_cast<std::uint16_t>(random.between(0, 9)),
                       .dark = static_cast<std::uint16_t>(random.between(0, 200)),
                       .min_amp2 = static_cast<std::uint16_t>(random.between(0, 300)),
                       .ratio_q16 = static_cast<std::uint32_t>(random.between(0, 65535))};
    if (n % 3 != 0) {  // up to what 16 bits hold
      limits.asymmetry_slope_q8 =
          static_cast<std::uint32_t>(random.between(0, n % 5 == 0 ? 4095 : 1023));
      limits.asymmetry_base = static_cast<std::uint32_t>(random.between(0, 65536));
    }
    if (n % 7 != 0) {
      const int most = n % 4 == 0 ? 4100 : 3003;
      limits.stray_i = static_cast<std::int16_t>(random.between(-most, most));
      limits.stray_q = static_cast<std::int16_t>(random.between(-most, most));
    }
    SampleRows samples = random_samples(c, top);
    run_kernel(c, samples, limits);
    // One sample of more bits than the sensor should have.
    const auto wide = c.array<std::uint16_t>(n);
    std::ranges::copy(samples[n % 4], wide.begin());
    if (n > 0) {
      wide[n / 2] = static_cast<std::uint16_t>(random.between(top + 1, 65535));
    }
    samples[n % 4] = wide;
    run_kernel(c, samples, limits);
  });
}

// Every amplitude of a 12-bit sensor with the largest stray light, one row each.
TEST(Phase, EqualsReferenceForEveryPairOfTwelveBitDifferences) {
  constexpr int kTop = 4095;
  constexpr std::size_t kStep = 3;
  const PhaseLimits limits{.saturation = kTop + 1, .stray_i = -4096, .stray_q = -4096};
  test::check_kernel_rounds((kTop + 1) / kStep, [&](test::KernelCase& c) {
    SampleRows samples;
    for (std::span<const std::uint16_t>& plane : samples) {
      plane = c.array<std::uint16_t>(kTop + 1, 0, 0);
    }
    const auto in_phase = c.array<std::uint16_t>(kTop + 1);
    std::iota(in_phase.begin(), in_phase.end(), std::uint16_t{0});
    samples[0] = in_phase;
    const int q = static_cast<int>(c.length() * kStep);
    samples[3] = c.array<std::uint16_t>(kTop + 1, q, q);
    run_kernel(c, samples, limits);
    run_kernel(c, samples, {});
  });
}

}  // namespace
}  // namespace stof::dsp

#include "hal/emu/imagery/noise.h"

#include <cmath>

#include <gtest/gtest.h>

#include "hal/emu/imagery/grey.h"
#include "hal/emu/imagery/pmd_samples.h"

namespace stof::test {
namespace {

using namespace hal::emu;

struct Moments {
  double mean = 0;
  double variance = 0;
};

template <typename T>
Moments moments(const std::vector<T>& values) {
  double sum = 0;
  double squares = 0;
  for (const T value : values) {
    sum += value;
    squares += static_cast<double>(value) * value;
  }
  const double n = static_cast<double>(values.size());
  return {sum / n, squares / n - sum / n * (sum / n)};
}

TEST(GaussianTable, IsAStandardNormalDistribution) {
  const auto& table = gaussian_table();
  constexpr double kOne = 1 << kGaussianBits;
  for (std::size_t i = 0; i < kGaussianSize; ++i) {
    EXPECT_EQ(table[i], -table[kGaussianSize - 1 - i]);
    EXPECT_TRUE(i == 0 || table[i] >= table[i - 1]);
    // The library's distribution function at the quantile; 1 LSB of the table moves it by 1e-4.
    EXPECT_NEAR(0.5 * std::erfc(-table[i] / kOne / std::sqrt(2.0)),
                (static_cast<double>(i) + 0.5) / kGaussianSize, 1e-4);
  }
  const Moments m = moments(std::vector<std::int16_t>(table.begin(), table.end()));
  EXPECT_NEAR(m.variance / (kOne * kOne), 1, 0.002);  // the tails beyond 3.7 sigma are missing
}

TEST(GreyNoise, HasShotAndReadVariance) {
  const GreyModel model{.black = 4, .electrons_per_level = 40, .read_noise = 0.7};
  const std::vector<std::uint16_t> sigma = grey_noise(model);
  for (const int level : {4, 60, 200}) {
    const dataset::Image<std::uint16_t> clean(320, 200,
                                              static_cast<std::uint16_t>(level << kGreyBits));
    dataset::Image<std::uint8_t> out(320, 200);
    expose_grey(clean.view(), sigma, /*seed=*/7, out.view());
    const Moments m = moments(out.pixels);
    const double expected = 0.7 * 0.7 + (level - 4) / 40.0 + 1 / 12.0;  // and rounding
    // 64,000 pixels: four standard errors of the mean and of the variance.
    EXPECT_NEAR(m.mean, level, 4 * std::sqrt(expected / 64000)) << level;
    EXPECT_NEAR(m.variance, expected, 0.025 * expected) << level;
  }
}

TEST(GreyNoise, ClipsAtWhite) {
  const std::vector<std::uint16_t> sigma = grey_noise({});
  const dataset::Image<std::uint16_t> clean(64, 8, static_cast<std::uint16_t>(400 << kGreyBits));
  dataset::Image<std::uint8_t> out(64, 8);
  expose_grey(clean.view(), sigma, 1, out.view());
  for (const std::uint8_t pixel : out.pixels) {
    EXPECT_EQ(pixel, 255);
  }
}

TEST(PmdNoise, HasTheModelsVariance) {
  constexpr dsp::Pinhole kFar{
      .width = 160, .height = 100, .fx = 1e5, .fy = 1e5, .cx = 79.5, .cy = 49.5};
  const PmdModel model{.emitters = {{0, 0, 0}}, .rays_per_side = 1};
  const Scene scene = wall(2, {.albedo = 0.5});
  const CleanSamples clean = render_pmd(scene, Viewpoint(scene, {}), kFar, {20'000'000}, model, {});
  for (int k = 0; k < 4; ++k) {
    dataset::Image<std::uint16_t> out(160, 100);
    expose_pmd(clean, k, 4095, /*seed=*/static_cast<std::uint64_t>(100 + k), out.view());
    const Moments m = moments(out.pixels);
    const double mean_lsb = clean.mean.view().at(80, k * 100 + 50) / double{1 << kPmdBits};
    const double collected =  // signal and correlation, electrons
        (mean_lsb - model.dark_lsb) * model.electrons_per_lsb - model.residual_e -
        (1 - model.suppression) * model.ambient_e * 0.5;
    const double expected =
        (collected + model.ambient_e * 0.5 + 150.0 * 150.0) / (61.0 * 61.0) + 1 / 12.0;
    EXPECT_NEAR(m.mean, mean_lsb, 4 * std::sqrt(expected / 16000));
    EXPECT_NEAR(m.variance, expected, 0.045 * expected);  // four standard errors of 16,000
  }
}

TEST(Noise, IsTheSameForOneSeedAndAnotherForTheNext) {
  const std::vector<std::uint16_t> sigma = grey_noise({});
  const dataset::Image<std::uint16_t> clean(64, 8, static_cast<std::uint16_t>(100 << kGreyBits));
  dataset::Image<std::uint8_t> a(64, 8);
  dataset::Image<std::uint8_t> b(64, 8);
  expose_grey(clean.view(), sigma, 5, a.view());
  expose_grey(clean.view(), sigma, 5, b.view());
  EXPECT_EQ(a.pixels, b.pixels);
  expose_grey(clean.view(), sigma, 6, b.view());
  EXPECT_NE(a.pixels, b.pixels);
}

}  // namespace
}  // namespace stof::test

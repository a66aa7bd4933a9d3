#include "hal/emu/imagery/pmd_samples.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using namespace hal::emu;

constexpr dsp::Hertz k20MHz{20'000'000};
constexpr double kTurnM = dsp::kLightMetresPerSecond / (2.0 * 20e6);
constexpr dsp::Pinhole kSmallLens{.width = 9, .height = 5, .fx = 20, .fy = 20, .cx = 4, .cy = 2};
constexpr int kX = 4;  // the pixel at the principal point
constexpr int kY = 2;

// One emitter in the lens, no harmonics, one ray a pixel: everything known in closed form.
PmdModel plain_model() {
  PmdModel model;
  model.kappa3 = 0;
  model.kappa5 = 0;
  model.emitters = {{0, 0, 0}};
  model.rays_per_side = 1;
  return model;
}

CleanSamples render(const Scene& scene, const PmdModel& model,
                    const dsp::Pinhole& lens = kSmallLens,
                    std::span<const std::int16_t> pattern = {}) {
  return render_pmd(scene, Viewpoint(scene, {}), lens, k20MHz, model, pattern);
}

double sample(const CleanSamples& clean, int k, int x = kX, int y = kY) {
  const int height = clean.mean.height / 4;
  return clean.mean.view().at(x, k * height + y) / double{1 << kPmdBits};
}
double in_phase(const CleanSamples& clean, int x = kX) {
  return sample(clean, 0, x) - sample(clean, 2, x);
}
double quadrature(const CleanSamples& clean, int x = kX) {
  return sample(clean, 3, x) - sample(clean, 1, x);
}
double phase(const CleanSamples& clean) {
  const double angle = std::atan2(quadrature(clean), in_phase(clean));
  return angle < 0 ? angle + 2 * std::numbers::pi : angle;
}

TEST(RenderPmd, WallGivesItsPhaseAmplitudeAndMean) {
  for (const double z : {1.0, 2.0, 3.5, 5.0, 7.0}) {
    const PmdModel model = plain_model();
    const CleanSamples clean = render(wall(z, {.albedo = 0.6}), model);
    const double signal = model.signal_e * 0.6 / (z * z);
    const double lsb = model.electrons_per_lsb;
    const double amplitude = std::hypot(in_phase(clean), quadrature(clean)) / 2;
    EXPECT_NEAR(amplitude, signal * model.contrast / lsb, 0.02) << z;  // 1/64 LSB steps
    // Steps of 1/64 LSB move the phase by at most that over the amplitude.
    EXPECT_NEAR(phase(clean), 2 * std::numbers::pi * z / kTurnM, 0.02 / amplitude) << z;
    const double mean =
        (sample(clean, 0) + sample(clean, 1) + sample(clean, 2) + sample(clean, 3)) / 4;
    const double kept = signal + (1 - model.suppression) * model.ambient_e * 0.6 + model.residual_e;
    EXPECT_NEAR(mean, kept / lsb + model.dark_lsb, 0.02) << z;
  }
}

TEST(RenderPmd, PhaseIsRadialAndWrapsAtTheUnambiguousRange) {
  const CleanSamples clean = render(wall(2), plain_model());
  const double x = 4 / kSmallLens.fx;
  const double radial = 2 * std::sqrt(1 + x * x);
  const double angle = std::atan2(quadrature(clean, kX + 4), in_phase(clean, kX + 4));
  EXPECT_NEAR(angle, 2 * std::numbers::pi * radial / kTurnM, 1e-3);
  const double behind = phase(render(wall(kTurnM + 1), plain_model()));
  EXPECT_NEAR(behind, 2 * std::numbers::pi / kTurnM, 1e-2);
}

TEST(RenderPmd, EmitterBesideTheLensLengthensThePath) {
  PmdModel model = plain_model();
  model.emitters = {{0.12, 0, 0}};
  const double path = 2.0 + std::sqrt(4 + 0.12 * 0.12);
  EXPECT_NEAR(phase(render(wall(2), model)), std::numbers::pi * path / kTurnM, 1e-4);
}

TEST(RenderPmd, PaneAddsItsEchoToWhatComesBackThroughIt) {
  constexpr double kTransmittance = 0.8;
  const PmdModel model = plain_model();
  Scene scene = wall(3);
  add(scene, Shape::kRectangle, {0, 0, 1.5}, {5, 5, 0},
      {.albedo = 0.05, .transmittance = kTransmittance});
  const CleanSamples both = render(scene, model);
  const CleanSamples far = render(wall(3), model);
  const CleanSamples near = render(wall(1.5, {.albedo = 0.05}), model);
  const double back = kTransmittance * kTransmittance;  // there and back
  EXPECT_NEAR(in_phase(both), back * in_phase(far) + in_phase(near), 0.05);
  EXPECT_NEAR(quadrature(both), back * quadrature(far) + quadrature(near), 0.05);
}

TEST(RenderPmd, OddHarmonicsBendThePhaseByTheCalibrationsTable) {
  PmdModel model = plain_model();
  model.kappa3 = 0.0497;
  model.kappa5 = 0.0111;
  const dsp::WigglingTable table = sensor_constants(kSmallLens, k20MHz, model).frequency.wiggling;
  for (double z = 1; z < 7; z += 0.23) {
    const double truth = 2 * std::numbers::pi * z / kTurnM;
    const double measured = phase(render(wall(z), model));
    const double bent = measured - truth;
    // First order in kappa: what is left is of size kappa^2.
    EXPECT_NEAR(bent, (model.kappa5 - model.kappa3) * std::sin(4 * truth), 0.003) << z;
    const std::size_t step =
        static_cast<std::size_t>(std::lround(measured / (2 * std::numbers::pi) * 128)) % 128;
    EXPECT_NEAR(bent, table[step] / 65536.0 * 2 * std::numbers::pi, 0.012) << z;  // table steps
  }
}

TEST(RenderPmd, EdgePixelIsTheMeanOfBothPhasors) {
  PmdModel model = plain_model();
  model.rays_per_side = 4;
  const Scene far = wall(3);
  Scene near;  // covers the left half of the pixel at the principal point
  near.objects.push_back(
      {.shape = Shape::kRectangle, .pose = {.position = {0, 0, 1.5}}, .half = {5, 5, 0}});
  Scene both = far;
  both.objects.push_back(
      {.shape = Shape::kRectangle, .pose = {.position = {-5, 0, 1.5}}, .half = {5, 5, 0}});
  const CleanSamples mixed = render(both, model);
  const CleanSamples a = render(near, model);
  const CleanSamples b = render(far, model);
  EXPECT_NEAR(in_phase(mixed), (in_phase(a) + in_phase(b)) / 2, 0.05);
  EXPECT_NEAR(quadrature(mixed), (quadrature(a) + quadrature(b)) / 2, 0.05);
  EXPECT_GT(std::abs(phase(a) - phase(b)), 1.0);
  EXPECT_GT(phase(mixed), phase(a));
  EXPECT_LT(phase(mixed), phase(b));
}

TEST(RenderPmd, FixedPatternTurnsTheMeasuredPhase) {
  PmdModel model = plain_model();
  model.kappa3 = 0.0497;
  model.kappa5 = 0.0111;
  const std::vector<std::int16_t> pattern(
      static_cast<std::size_t>(kSmallLens.width * kSmallLens.height), 900);
  for (double z = 1; z < 7; z += 0.4) {
    const double offset =
        phase(render(wall(z), model, kSmallLens, pattern)) - phase(render(wall(z), model));
    const double turn = 2 * std::numbers::pi;
    EXPECT_NEAR(std::remainder(offset, turn), 900 / 65536.0 * turn, 1e-3) << z;
  }
}

TEST(RenderPmd, NothingThereIsDarkAndWithoutPhase) {
  const PmdModel model = plain_model();
  const CleanSamples clean = render(Scene{}, model);
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(sample(clean, k), model.residual_e / model.electrons_per_lsb + model.dark_lsb,
                0.02);
  }
}

TEST(RenderPmd, StrayLightAddsItsPhasorToEveryPixel) {
  PmdModel model = plain_model();
  const CleanSamples without = render(wall(3), model);
  model.stray_e = 4000;
  model.stray_m = 1.5;
  const CleanSamples with = render(wall(3), model);
  const dsp::PmdFrequency frequency = sensor_constants(kSmallLens, k20MHz, model).frequency;
  const double angle = 2 * std::numbers::pi * 1.5 / kTurnM;
  EXPECT_NEAR(frequency.stray_i_lsb, 2 * 4000 / model.electrons_per_lsb * std::cos(angle), 1e-6);
  EXPECT_NEAR(frequency.stray_q_lsb, 2 * 4000 / model.electrons_per_lsb * std::sin(angle), 1e-6);
  for (const int x : {0, kX, 8}) {
    EXPECT_NEAR(in_phase(with, x) - in_phase(without, x), frequency.stray_i_lsb, 0.05);
    EXPECT_NEAR(quadrature(with, x) - quadrature(without, x), frequency.stray_q_lsb, 0.05);
  }
  // Its light fills the pixel and is noisy.
  const double light = 4000 / model.contrast / model.electrons_per_lsb;
  EXPECT_NEAR(sample(with, 0) + sample(with, 2) - sample(without, 0) - sample(without, 2),
              2 * light, 0.05);
  EXPECT_GT(with.sigma.view().at(kX, kY), without.sigma.view().at(kX, kY));
}

// tof noise model: a smooth wall seems to come nearer again beyond 4 m.
TEST(RenderPmd, StrayLightPullsAFarWallNearer) {
  PmdModel model = plain_model();
  model.signal_e = 205'000;
  model.stray_e = 4000;
  model.stray_m = 1.5;
  EXPECT_LT(phase(render(wall(6), model)), phase(render(wall(4), model)));
}

TEST(SensorConstants, WhiteIsTheAmplitudeOfAWhiteWallAtAMetre) {
  for (const double side : {0.0, 0.03, 0.12}) {
    PmdModel model = plain_model();
    model.emitters = {{-side, 0, 0}, {side, 0.01, 0.005}};
    model.signal_e = 150'000;
    const CleanSamples white = render(wall(1, {.albedo = 1}), model);
    const double amplitude = std::hypot(in_phase(white), quadrature(white)) / 2;
    EXPECT_NEAR(sensor_constants(kSmallLens, k20MHz, model).white_lsb, amplitude, 0.02) << side;
  }
  PmdModel bent;  // harmonics
  bent.signal_e = 150'000;
  const CleanSamples white = render(wall(1, {.albedo = 1}), bent);
  const double amplitude = std::hypot(in_phase(white), quadrature(white)) / 2;
  const double expected = sensor_constants(kSmallLens, k20MHz, bent).white_lsb;
  EXPECT_NEAR(amplitude / expected, 1, bent.kappa3 + bent.kappa5 + 0.002);
}

TEST(SensorConstants, NamesEmittersThatMatter) {
  PmdModel model = plain_model();
  EXPECT_EQ(sensor_constants(kSmallLens, k20MHz, model).emitter_count, 0);
  model.emitters = {{-0.03, 0, 0}, {0.03, 0, 0}};  // half a millimetre at half a metre
  EXPECT_EQ(sensor_constants(kSmallLens, k20MHz, model).emitter_count, 0);
  model.emitters = {{0.12, 0.01, -0.02}};
  const dsp::PmdSensor sensor = sensor_constants(kSmallLens, k20MHz, model);
  ASSERT_EQ(sensor.emitter_count, 1);
  const dsp::Emitter& e = sensor.emitters[0];
  EXPECT_EQ(e, (dsp::Emitter{0.12, 0.01, -0.02}));
  // The near model with these: d = ((ct)^2 - |e|^2) / (2 (ct - e r)), on the axis r = (0, 0, 1).
  for (const double z : {0.5, 0.8, 1.5}) {
    const double path = phase(render(wall(z, {.albedo = 0.1}), model)) / std::numbers::pi * kTurnM;
    const double square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
    EXPECT_NEAR((path * path - square) / (2 * (path - e[2])), z, 2e-4) << z;
  }
}

TEST(SensorConstants, BitsAreHonoured) {
  for (int bits = 10; bits <= 15; ++bits) {
    PmdModel model = plain_model();
    model.bits = bits;
    const int largest = sensor_constants(kSmallLens, k20MHz, model).saturation_lsb;
    EXPECT_EQ(largest, (1 << bits) - 1);
    const CleanSamples clean = render(wall(0.1), model);
    dataset::Image<std::uint16_t> out(kSmallLens.width, kSmallLens.height);
    expose_pmd(clean, 0, largest, 3, out.view());
    EXPECT_EQ(out.view().at(kX, kY), largest);
  }
}

TEST(ExposePmd, NearWhiteSurfacesSaturate) {
  PmdModel model = plain_model();
  const CleanSamples clean = render(wall(0.4), model);
  for (int k = 0; k < 4; ++k) {
    dataset::Image<std::uint16_t> out(kSmallLens.width, kSmallLens.height);
    expose_pmd(clean, k, 4095, 3, out.view());
    EXPECT_EQ(out.view().at(kX, kY), 4095) << k;
  }
}

TEST(UndistortedRay, IsUndoneByTheLens) {
  dsp::Pinhole lens{.width = 176, .height = 144, .fx = 159, .fy = 161, .cx = 88, .cy = 71};
  for (const double k1 : {0.0, -0.06, 0.05}) {
    for (const double tangential : {0.0, 0.002}) {
      lens.k1 = k1;
      lens.k2 = k1 / 5;
      lens.k3 = k1 / 20;
      lens.p1 = tangential;
      lens.p2 = -tangential / 2;
      for (const double u : {0.0, 40.0, 88.0, 175.0}) {
        for (const double v : {0.0, 71.0, 143.0}) {
          const Vec3 ray = undistorted_ray(lens, u, v);
          const double x = ray.x;
          const double y = ray.y;
          const double square = x * x + y * y;
          const double stretch = 1 + square * (lens.k1 + square * (lens.k2 + square * lens.k3));
          const double dx = 2 * lens.p1 * x * y + lens.p2 * (square + 2 * x * x);
          const double dy = lens.p1 * (square + 2 * y * y) + 2 * lens.p2 * x * y;
          EXPECT_NEAR((x * stretch + dx) * lens.fx + lens.cx, u, 1e-6);
          EXPECT_NEAR((y * stretch + dy) * lens.fy + lens.cy, v, 1e-6);
        }
      }
    }
  }
}

TEST(MakePattern, HasItsSizeAndSpread) {
  PmdModel model;
  model.pattern_rms_m = 0.01;
  const dsp::Pinhole lens{.width = 100, .height = 80};
  double squares = 0;
  const std::vector<std::int16_t> pattern = make_pattern(lens, k20MHz, model, 9);
  ASSERT_EQ(pattern.size(), 8000U);
  for (const std::int16_t offset : pattern) {
    squares += offset * offset;
  }
  const double expected = 0.01 / kTurnM * 65536;
  EXPECT_NEAR(std::sqrt(squares / 8000), expected, 0.035 * expected);  // four standard errors
}

}  // namespace
}  // namespace stof::test

#include <cmath>

#include "dataset/dataset.h"
#include "tests/dataset/scratch.h"
#include "tests/support/random.h"

namespace stof::dataset {
namespace {

using test::expect_one_line_about;

constexpr int kWidth = 5;
constexpr int kHeight = 3;

std::vector<Image<std::uint16_t>> some_frames(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Image<std::uint16_t>> frames(count, Image<std::uint16_t>(kWidth, 4 * kHeight));
  for (Image<std::uint16_t>& frame : frames) {
    random.fill(std::span(frame.pixels));
  }
  return frames;
}

// Every number has another value, and none of them is round.
PmdRecording some_recording() {
  PmdRecording recording;
  recording.frames = some_frames(3, 1);
  recording.after_pair_us = -6001;
  test::Random random(2);
  recording.fixed_pattern.resize(kWidth * kHeight);
  random.fill(std::span(recording.fixed_pattern));
  recording.fixed_pattern[0] = -32768;
  recording.fixed_pattern[1] = 32767;
  dsp::PmdSensor& pmd = recording.calibration.pmd;
  pmd.lens = {.width = kWidth,
              .height = kHeight,
              .fx = 45.1,
              .fy = 45.2,
              .cx = 2.3,
              .cy = 1.7,
              .k1 = -0.11,
              .k2 = 0.013,
              .k3 = -0.0017,
              .p1 = 0.00019,
              .p2 = -0.00023};
  pmd.frequency.modulation.value = 20'000'001;
  pmd.frequency.min_modulation_ratio = 0.27;
  pmd.frequency.offset_m = -0.1 / 3;
  pmd.frequency.offset_m_per_k = 0.0011;
  pmd.frequency.stray_i_lsb = 12.3;
  pmd.frequency.stray_q_lsb = -4.7;
  random.fill(std::span<std::int16_t>(pmd.frequency.wiggling), -500, 500);
  pmd.phase_falls = true;
  pmd.dark_lsb = 100.1;
  pmd.saturation_lsb = 4001;
  pmd.under_lsb = 3;
  pmd.min_amplitude_lsb = 7;
  pmd.asymmetry_sigmas = 5.9;
  pmd.electrons_per_lsb = 61.05006105006105;
  pmd.noise_lsb = 310 / 61.05006105006105;
  pmd.suppressed_lsb = 233.1;
  pmd.sigma_polynomial = dsp::SigmaPolynomial{.a = 0.13, .b = 0.0021, .c = 0.000029};
  pmd.integration_us = 80000.1;
  pmd.reference_c = 31.7;
  pmd.scale = 1.003;
  pmd.shift_m = -0.0021;
  pmd.emitter_count = 2;
  pmd.emitters[0] = {-0.12, 0.01, 0.003};
  pmd.emitters[1] = {0.11, -0.02, 0.004};
  pmd.white_lsb = 1511.1;
  pmd.fixed_pattern = recording.fixed_pattern;
  return recording;
}

void put_rig(PmdRecording& recording) {
  recording.has_rig = true;
  dsp::Calibration& rig = recording.calibration;
  rig.stereo = {.left = {.width = 450,
                         .height = 375,
                         .fx = 1105.9103319910212,
                         .fy = 1105.8,
                         .cx = 224.5,
                         .cy = 187.1},
                .baseline_m = 0.2001,
                .doff_px = -40.045516599551064};
  const double turn = 0.1;
  rig.pmd_to_stereo = {
      .rotation = {1, 0, 0, 0, std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn)},
      .translation_m = {0.01, 0.3, 0.2}};
}

void expect_equal(const dsp::Pinhole& a, const dsp::Pinhole& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  const auto numbers = [](const dsp::Pinhole& of) {
    return std::array{of.fx, of.fy, of.cx, of.cy, of.k1, of.k2, of.k3, of.p1, of.p2};
  };
  EXPECT_EQ(numbers(a), numbers(b));
}

void expect_equal(const dsp::PmdFrequency& a, const dsp::PmdFrequency& b) {
  EXPECT_EQ(a.modulation.value, b.modulation.value);
  const auto numbers = [](const dsp::PmdFrequency& of) {
    return std::array{of.min_modulation_ratio, of.offset_m, of.offset_m_per_k, of.stray_i_lsb,
                      of.stray_q_lsb};
  };
  EXPECT_EQ(numbers(a), numbers(b));
  EXPECT_EQ(a.wiggling, b.wiggling);
}

void expect_equal(const dsp::PmdSensor& a, const dsp::PmdSensor& b) {
  expect_equal(a.lens, b.lens);
  expect_equal(a.frequency, b.frequency);
  EXPECT_EQ(a.phase_falls, b.phase_falls);
  const auto counts = [](const dsp::PmdSensor& of) {
    return std::array{of.saturation_lsb, of.under_lsb, of.min_amplitude_lsb, of.emitter_count};
  };
  EXPECT_EQ(counts(a), counts(b));
  const auto numbers = [](const dsp::PmdSensor& of) {
    return std::array{of.dark_lsb,       of.asymmetry_sigmas, of.electrons_per_lsb, of.noise_lsb,
                      of.suppressed_lsb, of.integration_us,   of.reference_c,       of.scale,
                      of.shift_m,        of.white_lsb};
  };
  EXPECT_EQ(numbers(a), numbers(b));
  EXPECT_EQ(a.emitters, b.emitters);
  ASSERT_EQ(a.sigma_polynomial.has_value(), b.sigma_polynomial.has_value());
  if (a.sigma_polynomial) {
    EXPECT_EQ(a.sigma_polynomial->a, b.sigma_polynomial->a);
    EXPECT_EQ(a.sigma_polynomial->b, b.sigma_polynomial->b);
    EXPECT_EQ(a.sigma_polynomial->c, b.sigma_polynomial->c);
  }
  EXPECT_TRUE(std::ranges::equal(a.fixed_pattern, b.fixed_pattern));
}

void expect_equal(const std::vector<Image<std::uint16_t>>& a,
                  const std::vector<Image<std::uint16_t>>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].width, b[i].width);
    EXPECT_EQ(a[i].pixels, b[i].pixels) << i;
  }
}

class WrittenPmd : public test::Scratch {
 protected:
  std::filesystem::path prefix() const { return folder() / "one"; }

  void expect_refused(const PmdRecording& recording, std::string_view fact) const {
    const std::expected<void, Problem> written = write_pmd(prefix(), recording);
    ASSERT_FALSE(written) << fact;
    expect_one_line_about(written.error().message, prefix().string() + ".json", fact);
    EXPECT_TRUE(std::filesystem::is_empty(folder()));
  }
};

TEST_F(WrittenPmd, ReadsBackEqual) {
  PmdRecording recording = some_recording();
  for (const bool rig : {false, true}) {
    if (rig) {
      put_rig(recording);
    }
    const std::expected<void, Problem> written = write_pmd(prefix(), recording);
    ASSERT_TRUE(written) << written.error().message;
    const Loaded<PmdRecording> again = read_pmd(prefix());
    ASSERT_TRUE(again) << again.error().message;
    expect_equal(again->frames, recording.frames);
    expect_equal(again->calibration.pmd, recording.calibration.pmd);
    ASSERT_EQ(again->has_rig, rig);
    EXPECT_EQ(again->after_pair_us, -6001);
  }
  const dsp::Calibration got = read_pmd(prefix())->calibration;
  const dsp::Calibration& want = recording.calibration;
  expect_equal(got.stereo.left, want.stereo.left);
  EXPECT_EQ(got.stereo.baseline_m, want.stereo.baseline_m);
  EXPECT_EQ(got.stereo.doff_px, want.stereo.doff_px);
  EXPECT_EQ(got.pmd_to_stereo.rotation, want.pmd_to_stereo.rotation);
  EXPECT_EQ(got.pmd_to_stereo.translation_m, want.pmd_to_stereo.translation_m);
}

TEST_F(WrittenPmd, WithoutFixedPatternDoesNotTakeThatOfItsFolder) {
  PmdRecording recording = some_recording();
  ASSERT_TRUE(write_pmd(prefix(), recording));  // leaves one_fppn.pgm
  put("5x3_fppn.pgm", "P5\n5 3\n255\n123456789012345");
  recording.calibration.pmd.fixed_pattern = {};
  recording.calibration.pmd.sigma_polynomial.reset();
  ASSERT_TRUE(write_pmd(prefix(), recording));
  const Loaded<PmdRecording> again = read_pmd(prefix());
  ASSERT_TRUE(again) << again.error().message;
  expect_equal(again->calibration.pmd, recording.calibration.pmd);
}

TEST_F(WrittenPmd, IsRefusedWithFramesOfAnotherSize) {
  PmdRecording recording = some_recording();
  recording.frames[1] = Image<std::uint16_t>(kWidth, 4 * kHeight - 1);
  expect_refused(recording, "have not the size of the sensor");
  recording.frames.clear();
  expect_refused(recording, "there are no frames");
}

TEST_F(WrittenPmd, IsRefusedWithNumbersThatCannotBeReadBack) {
  PmdRecording recording = some_recording();
  recording.calibration.pmd.noise_lsb = std::nan("");
  expect_refused(recording, "noise");
  recording = some_recording();
  recording.calibration.pmd.fixed_pattern = std::span(recording.fixed_pattern).first(3);
  expect_refused(recording, "fixed pattern");
}

TEST_F(WrittenPmd, SaysWhereItCannotBeWritten) {
  const std::expected<void, Problem> written =
      write_pmd(folder() / "absent" / "one", some_recording());
  ASSERT_FALSE(written);
  expect_one_line_about(written.error().message, folder() / "absent" / "one_fppn.pgm",
                        "cannot be written");
}

}  // namespace
}  // namespace stof::dataset

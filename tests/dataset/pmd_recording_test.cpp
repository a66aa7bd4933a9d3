#include <array>
#include <cmath>

#include "dataset/dataset.h"
#include "tests/dataset/scratch.h"

namespace stof::dataset {
namespace {

using test::expect_one_line_about;
using namespace std::string_view_literals;

// A camera of 2x1 pixels: one frame is four planes of two samples.
constexpr std::string_view kConstants =
    R"({"width": 2, "height": 1, "f_mod_hz": 20000000.0, "dark_lsb": 100.5, "sat_lsb": 4000,
        "fx": 40.0, "fy": 41, "cx": 0.5, "cy": 0.25, "k1": -0.1, "k2": 0.01,
        "kappa3": 0.05, "kappa5": 0.01, "lsb_e": 50.0, "read_e": 300.0, "ambient_e": 15000.0, "sbi": 0.95})";
constexpr std::string_view kRig =
    R"(, "R": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "T": [0.1, 0.2, 0.3],
        "stereo": {"f_px": 1000.0, "baseline_m": 0.2, "doff_px": 30.0, "cx": 200.0, "cy": 100.0}})";
constexpr std::string_view kSamples =
    "P5\n2 4\n4095\n\x00\x01\x00\x02\x00\x03\x00\x04\x00\x05\x00\x06\x00\x07\x00\x08"sv;

std::string replaced(std::string_view text, std::string_view what, std::string_view with) {
  std::string result(text);
  const std::size_t at = result.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? result : result.replace(at, what.size(), with);
}

std::string with_rig() {
  return std::string(kConstants.substr(0, kConstants.size() - 1)) + std::string(kRig);
}

class PmdRecordings : public test::Scratch {
 protected:
  PmdRecordings() {
    put("cam.json", kConstants);
    put("cam_raw.pgm", kSamples);
  }
  std::filesystem::path prefix() const { return folder() / "cam"; }
  void expect_refused(const char* name, std::string_view fact) const {
    const Loaded<PmdRecording> recording = read_pmd(prefix());
    ASSERT_FALSE(recording) << fact;
    expect_one_line_about(recording.error().message, folder() / name, fact);
  }
};

TEST_F(PmdRecordings, GiveTheConstantsInTheUnitsOfTheCalibration) {
  const Loaded<PmdRecording> recording = read_pmd(prefix());
  ASSERT_TRUE(recording) << recording.error().message;
  const dsp::PmdSensor& sensor = recording->calibration.pmd;
  EXPECT_EQ(sensor.lens.width, 2);
  EXPECT_EQ(sensor.lens.height, 1);
  EXPECT_EQ(sensor.lens.fx, 40);
  EXPECT_EQ(sensor.lens.fy, 41);
  EXPECT_EQ(sensor.lens.cx, 0.5);
  EXPECT_EQ(sensor.lens.cy, 0.25);
  EXPECT_EQ(sensor.lens.k1, -0.1);
  EXPECT_EQ(sensor.lens.k2, 0.01);
  EXPECT_EQ(sensor.frequency.modulation.value, 20'000'000U);
  EXPECT_EQ(sensor.dark_lsb, 100.5);
  EXPECT_EQ(sensor.saturation_lsb, 4000);
  EXPECT_EQ(sensor.electrons_per_lsb, 50);
  EXPECT_EQ(sensor.noise_lsb, 6);
  EXPECT_EQ(sensor.suppressed_lsb, 0.95 * 15000 / 50);
  EXPECT_EQ(sensor.frequency.wiggling, dsp::wiggling_of_harmonics(0.05, 0.01));
  EXPECT_TRUE(sensor.fixed_pattern.empty());
  EXPECT_FALSE(recording->has_rig);
}

TEST_F(PmdRecordings, GiveWhatALaterSimulatorSaysOfLensAndLights) {
  put("cam.json", replaced(kConstants, "\"k2\": 0.01",
                           R"("k2": 0.01, "k3": -0.001, "p1": 0.002, "p2": -0.003,
                              "contrast": 0.5, "s1_e": 200000.0, "int_scale": 0.25,
                              "stray": [4000.0, 1.5],
                              "emitters": [[-0.12, 0.0, 0.01], [0.12, 0, 0.02]])"));
  const Loaded<PmdRecording> recording = read_pmd(prefix());
  ASSERT_TRUE(recording) << recording.error().message;
  const dsp::PmdSensor& sensor = recording->calibration.pmd;
  EXPECT_EQ(sensor.lens.k3, -0.001);
  EXPECT_EQ(sensor.lens.p1, 0.002);
  EXPECT_EQ(sensor.lens.p2, -0.003);
  EXPECT_EQ(sensor.white_lsb, 500);  // 0.5 * 200000 / 50 a quarter as long
  EXPECT_EQ(sensor.suppressed_lsb, 0.95 * 15000 * 0.25 / 50);  // collects a quarter of the light
  EXPECT_EQ(sensor.emitter_count, 2);
  EXPECT_EQ(sensor.emitters[0], (dsp::Emitter{-0.12, 0, 0.01}));
  EXPECT_EQ(sensor.emitters[1], (dsp::Emitter{0.12, 0, 0.02}));
  EXPECT_EQ(sensor.frequency.stray_i_lsb, 0);  // what the simulated camera has is truth
  EXPECT_EQ(sensor.frequency.stray_q_lsb, 0);
}

TEST_F(PmdRecordings, GiveWhatACalibrationSaysBeforeWhatFollowsFromElectrons) {
  put("cam.json", replaced(kConstants, "\"k2\": 0.01",
                           R"("k2": 0.01, "contrast": 0.5, "s1_e": 200000.0, "noise_lsb": 1.5,
                              "suppressed_lsb": 2.5, "white_lsb": 3.5, "stray_i_lsb": -4.5)"));
  const Loaded<PmdRecording> recording = read_pmd(prefix());
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->calibration.pmd.noise_lsb, 1.5);
  EXPECT_EQ(recording->calibration.pmd.suppressed_lsb, 2.5);
  EXPECT_EQ(recording->calibration.pmd.white_lsb, 3.5);
  EXPECT_EQ(recording->calibration.pmd.frequency.stray_i_lsb, -4.5);
}

TEST_F(PmdRecordings, TakeTheNearestFixedPatternOrTheOneThatIsNamed) {
  const auto first_value = [&](const std::optional<std::filesystem::path>& named = {}) {
    const Loaded<PmdRecording> recording = read_pmd(prefix(), named);
    EXPECT_TRUE(recording) << recording.error().message;
    return !recording || recording->fixed_pattern.empty() ? 0 : recording->fixed_pattern[0];
  };
  const std::filesystem::path named = put("there/x.pgm", "P5\n2 1\n65535\n\x80\x50\x80\x00"sv);
  EXPECT_EQ(first_value(), 0);
  put("2x1_fppn.pgm", "P5\n2 1\n65535\n\x80\x08\x80\x00"sv);
  EXPECT_EQ(first_value(), 9);  // 1 mm
  put("cam_fppn.pgm", "P5\n2 1\n65535\n\x80\x10\x80\x00"sv);
  EXPECT_EQ(first_value(), 17);       // 2 mm
  EXPECT_EQ(first_value(named), 87);  // 10 mm
  put("cam.json", replaced(kConstants, R"("k2")", R"("fppn_unit": "1/65536 turn", "k2")"));
  EXPECT_EQ(first_value(), 16);
  EXPECT_EQ(first_value(named), 87);
  put("cam.json", replaced(kConstants, R"("k2")", R"("fppn_unit": "none", "k2")"));
  EXPECT_EQ(first_value(), 0);
  put("cam.json", replaced(kConstants, R"("k2")", R"("fppn_unit": "inch", "k2")"));
  expect_refused("cam.json", "\"fppn_unit\"");
  put("cam.json", kConstants);
  const Loaded<PmdRecording> absent = read_pmd(prefix(), folder() / "absent.pgm");
  ASSERT_FALSE(absent);
  expect_one_line_about(absent.error().message, folder() / "absent.pgm", "does not exist");
}

TEST_F(PmdRecordings, ArePairedWithTheHigherFrequencyFirst) {
  put("two.json", replaced(kConstants, "20000000.0", "18750000"));
  put("two_raw.pgm", "P5\n2 4\n255\n12345678");
  for (const bool turned : {false, true}) {
    const Loaded<PmdRecording> pair = turned ? read_pmd_pair(folder() / "two", prefix())
                                             : read_pmd_pair(prefix(), folder() / "two");
    ASSERT_TRUE(pair) << pair.error().message;
    EXPECT_EQ(pair->calibration.pmd.frequency.modulation.value, 20'000'000U);
    ASSERT_TRUE(pair->calibration.pmd.second);
    EXPECT_EQ(pair->calibration.pmd.second->modulation.value, 18'750'000U);
    EXPECT_EQ(pair->calibration.pmd.frequency.min_modulation_ratio, 0.25);
    EXPECT_EQ(pair->calibration.pmd.second->min_modulation_ratio, 0.25);
    ASSERT_EQ(pair->frames.size(), 1U);
    ASSERT_EQ(pair->second_frames.size(), 1U);
    EXPECT_EQ(pair->samples(0)[1].at(0, 0), 3);
    EXPECT_EQ(pair->second_samples(0)[1].at(0, 0), '3');
  }
}

TEST_F(PmdRecordings, AreNotPairedUnlessTheyBelongTogether) {
  const std::string other = replaced(kConstants, "20000000.0", "18750000");
  const auto expect_no_pair = [&](std::string_view json, std::string_view fact) {
    put("two.json", json);
    put("two_raw.pgm", kSamples);
    const Loaded<PmdRecording> pair = read_pmd_pair(prefix(), folder() / "two");
    ASSERT_FALSE(pair) << fact;
    expect_one_line_about(pair.error().message, folder() / "two.json", fact);
  };
  expect_no_pair(kConstants, "not below the first");
  expect_no_pair(replaced(kConstants, "20000000.0", "18750001"), "whole numbers");
  expect_no_pair(replaced(other, "\"fx\": 40.0", "\"fx\": 40.5"), "not of the camera");
  expect_no_pair(replaced(other, "100.5", "101"), "not of the camera");
  put("two.json", replaced(other, R"("width")", R"("frames": 2, "width")"));
  put("two_raw.pgm", "P5\n2 8\n255\n1234567812345678");
  const Loaded<PmdRecording> pair = read_pmd_pair(prefix(), folder() / "two");
  ASSERT_FALSE(pair);
  expect_one_line_about(pair.error().message, folder() / "two.json", "not as many frames");
}

TEST_F(PmdRecordings, SplitTheStackIntoFourSamples) {
  const Loaded<PmdRecording> recording = read_pmd(prefix());
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames.size(), 1U);
  const auto samples = recording->samples(0);
  for (int k = 0; k < 4; ++k) {
    const dsp::ImageView<const std::uint16_t>& plane = samples[static_cast<std::size_t>(k)];
    ASSERT_EQ(plane.width(), 2);
    ASSERT_EQ(plane.height(), 1);
    EXPECT_EQ(plane.at(0, 0), 2 * k + 1);
    EXPECT_EQ(plane.at(1, 0), 2 * k + 2);
  }
}

TEST_F(PmdRecordings, HoldSeveralFrames) {
  put("cam.json", replaced(kConstants, R"("width")", R"("frames": 2, "width")"));
  put("cam_raw.pgm", "P5\n2 8\n255\n" + std::string("abcdefghijklmnop"));
  const Loaded<PmdRecording> recording = read_pmd(prefix());
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames.size(), 2U);
  EXPECT_EQ(recording->samples(0)[3].at(1, 0), 'h');
  EXPECT_EQ(recording->samples(1)[0].at(0, 0), 'i');
}

TEST_F(PmdRecordings, GiveTheRigWhereThereIsOne) {
  put("cam.json", with_rig());
  const Loaded<PmdRecording> recording = read_pmd(prefix());
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_TRUE(recording->has_rig);
  const dsp::Calibration& rig = recording->calibration;
  EXPECT_EQ(rig.pmd_to_stereo.rotation, (std::array<double, 9>{0, -1, 0, 1, 0, 0, 0, 0, 1}));
  EXPECT_EQ(rig.pmd_to_stereo.translation_m, (std::array<double, 3>{0.1, 0.2, 0.3}));
  EXPECT_EQ(rig.stereo.left.fx, 1000);
  EXPECT_EQ(rig.stereo.left.fy, 1000);
  EXPECT_EQ(rig.stereo.left.cx, 200);
  EXPECT_EQ(rig.stereo.left.cy, 100);
  EXPECT_EQ(rig.stereo.baseline_m, 0.2);
  EXPECT_EQ(rig.stereo.doff_px, 30);
}

TEST_F(PmdRecordings, TurnTheFixedPatternIntoPhaseThatWraps) {
  // 8 units of 1/8 mm above and 32768 below: 1 mm and -4096 mm; one turn is 7494.8114 mm.
  put("2x1_fppn.pgm", "P5\n2 1\n65535\n\x80\x08\x00\x00"sv);
  Loaded<PmdRecording> recording = read_pmd(prefix());
  ASSERT_TRUE(recording) << recording.error().message;
  const std::span<const std::int16_t> pattern = recording->calibration.pmd.fixed_pattern;
  ASSERT_EQ(pattern.size(), 2U);
  EXPECT_EQ(pattern[0], 9);               // 8.744
  EXPECT_EQ(pattern[1], -35816 + 65536);  // -35816.3, half a turn and more
  const PmdRecording moved = std::move(*recording);
  EXPECT_EQ(moved.calibration.pmd.fixed_pattern.data(), moved.fixed_pattern.data());
}

TEST_F(PmdRecordings, AreRefusedWithAFixedPatternOfAnotherSize) {
  put("2x1_fppn.pgm", "P5\n1 2\n65535\n1234"sv);
  expect_refused("2x1_fppn.pgm", "expected 2x1, found 1x2");
}

TEST_F(PmdRecordings, AreRefusedWithSamplesOfTheWrongSize) {
  put("cam_raw.pgm", "P5\n2 3\n255\n123456"sv);
  expect_refused("cam_raw.pgm", "expected 2x4");
  expect_refused("cam_raw.pgm", "found 2x3");
}

TEST_F(PmdRecordings, AreRefusedWithTruncatedSamples) {
  put("cam_raw.pgm", kSamples.substr(0, kSamples.size() - 3));
  expect_refused("cam_raw.pgm", "take 16 bytes but 13 are there");
}

TEST_F(PmdRecordings, AreRefusedWithoutTheirFiles) {
  std::filesystem::remove(folder() / "cam_raw.pgm");
  expect_refused("cam_raw.pgm", "does not exist");
  std::filesystem::remove(folder() / "cam.json");
  expect_refused("cam.json", "does not exist");
}

TEST_F(PmdRecordings, AreRefusedWithoutOneOfTheNeededKeys) {
  for (const char* key : {"width", "height", "f_mod_hz", "dark_lsb", "sat_lsb", "fx", "fy", "cx",
                          "cy", "lsb_e", "read_e", "R", "T", "f_px", "baseline_m", "doff_px"}) {
    const std::string quoted = "\"" + std::string(key) + "\"";
    put("cam.json", replaced(with_rig(), quoted, "\"other\""));
    expect_refused("cam.json", quoted);
  }
}

TEST_F(PmdRecordings, AreRefusedWithUnusableNumbers) {
  constexpr std::pair<std::string_view, std::string_view> kBad[] = {
      {"\"width\": 2", "\"width\": 2.5"},
      {"\"width\": 2", "\"width\": -2"},
      {"\"width\": 2", "\"width\": 1e300"},
      {R"("width": 2)", R"("width": "2")"},
      {"\"width\": 2", "\"width\": null"},
      {"20000000.0", "0"},
      {"20000000.0", "999999"},
      {"\"fx\": 40.0", "\"fx\": 0"},
      {"\"fx\": 40.0", "\"fx\": [40]"},
      {"\"lsb_e\": 50.0", "\"lsb_e\": 0"},
      {"\"read_e\": 300.0", "\"read_e\": -1"},
      {"\"dark_lsb\": 100.5", "\"dark_lsb\": 1e9"},
      {"\"kappa3\": 0.05", "\"kappa3\": 50"},
      {"\"sbi\": 0.95", "\"sbi\": -1"},
      {"\"kappa3\": 0.05", "\"wiggling\": [1, 2]"},
      {"\"kappa3\": 0.05", "\"emitters\": [[0, 1]]"},
      {"\"kappa3\": 0.05", "\"emitters\": 0.12"},
      {R"("kappa3": 0.05)", R"("emitters": [[0, 1, "x"]])"},
      {"\"kappa3\": 0.05", "\"emitters\": [[0, 0, 3]]"},
      {"\"kappa3\": 0.05", "\"emitters\": [[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]"},
      {"\"kappa3\": 0.05", "\"sigma_polynomial\": [1, 2]"},
      {"\"kappa3\": 0.05", "\"phase_falls\": 2"},
      {"\"kappa3\": 0.05", "\"scale\": 3"},
      {"[0, -1, 0]", "[0, -2, 0]"},
      {"[0, -1, 0]", "[0, -1]"},
      {"[0.1, 0.2, 0.3]", "[0.1, \"x\", 0.3]"},
      {"[0.1, 0.2, 0.3]", "[0.1, 0.2, 1e9]"},
      {"\"baseline_m\": 0.2", "\"baseline_m\": -0.2"},
      {"\"f_px\": 1000.0", "\"f_px\": false"},
  };
  for (const auto& [what, with] : kBad) {
    put("cam.json", replaced(with_rig(), what, with));
    expect_refused("cam.json", "");
  }
}

TEST_F(PmdRecordings, AreRefusedWithWhatNoCameraHas) {
  constexpr std::array<std::array<const char*, 3>, 8> kBad{{
      {"\"dark_lsb\": 100.5", "\"dark_lsb\": 4000", "dark level"},
      {"\"fx\": 40.0", "\"fx\": 1e-9", "focal length"},
      {"\"cx\": 0.5", "\"cx\": 1e9", "centre"},
      {"\"lsb_e\": 50.0", "\"lsb_e\": 1e12", "electrons per LSB"},
      {"\"baseline_m\": 0.2", "\"baseline_m\": 500", "baseline"},
      {R"("doff_px": 30.0)", R"("width": 450, "height": 375, "doff_px": -1000)",
       "disparity offset"},
      {R"("k1": -0.1)", R"("k1": -0.1, "k1": -0.1)", R"(has "k1" twice)"},
      {R"("cx": 200.0)", R"("cx": 200.0, "cx": 100.0)", R"(has "cx" twice)"},
  }};
  for (const auto& [what, with, fact] : kBad) {
    put("cam.json", replaced(with_rig(), what, with));
    expect_refused("cam.json", fact);
  }
}

TEST_F(PmdRecordings, AreRefusedWithWhatIsNotJson) {
  const std::string deep = std::string(100000, '[');
  for (const std::string_view text :
       {""sv, "{"sv, "[]"sv, "7"sv, "\xff\xfe"sv, R"({"width": NaN})"sv, R"({"width": 1e999})"sv,
        std::string_view(deep)}) {
    put("cam.json", text);
    expect_refused("cam.json", "is not a JSON object");
  }
}

}  // namespace
}  // namespace stof::dataset

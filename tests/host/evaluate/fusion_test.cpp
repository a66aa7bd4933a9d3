#include "host/evaluate/fusion/fusion.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "host/evaluate/fusion/chapter_geometry.h"
#include "host/evaluate/fusion/fusion_case.h"
#include "tests/host/evaluate/fusion_scene.h"

namespace stof::host {
namespace {

MatchRequest preset(const std::string& name,
                    std::vector<std::pair<std::string, std::string>> settings = {}) {
  return {.preset = name, .settings = std::move(settings)};
}

TEST(ApplyCalibration, RefusesThatOfAnotherCamera) {
  const dataset::PmdRecording told = test::flat_recording(2);
  const auto refused = [](const dsp::PmdSensor& found, const std::string& fact) {
    dataset::PmdRecording recording = test::flat_recording(2);
    const auto applied = apply_calibration(found, "wall", recording);
    ASSERT_FALSE(applied) << fact;
    EXPECT_EQ(applied.error().message.find("wall.json: the recording's " + fact), 0U)
        << applied.error().message;
  };
  dsp::PmdSensor found = told.calibration.pmd;
  found.frequency.modulation.value = 15'000'000;
  refused(found, "modulation frequency is 20 MHz, the calibration's 15 MHz: give");
  found = told.calibration.pmd;
  found.saturation_lsb = 1023;
  refused(found, "saturation is 4095 LSB, the calibration's 1023 LSB");
  found = told.calibration.pmd;
  found.integration_us = 500;
  dataset::PmdRecording recording = test::flat_recording(2);
  EXPECT_TRUE(apply_calibration(found, "wall", recording));  // the recording does not tell
  recording.calibration.pmd.integration_us = 1000;
  EXPECT_FALSE(apply_calibration(found, "wall", recording));
}

TEST(ApplyCalibration, SaysWhatItCarriesToAPictureOfAnotherSize) {
  const dataset::PmdRecording told = test::flat_recording(2);
  dsp::PmdSensor found = told.calibration.pmd;
  found.frequency.offset_m = 0.1;
  const std::vector<std::int16_t> pattern(8, 5);
  found.fixed_pattern = pattern;
  dataset::PmdRecording recording = test::flat_recording(2);
  EXPECT_EQ(apply_calibration(found, "wall", recording).value_or("refused"), "");
  EXPECT_EQ(recording.calibration.pmd.fixed_pattern.data(), pattern.data());
  found.lens.width = 8;
  recording = test::flat_recording(2);
  const std::string note = apply_calibration(found, "wall", recording).value_or("refused");
  EXPECT_NE(note.find("8x2 pixels for recordings of 4x2"), std::string::npos) << note;
  EXPECT_NE(note.find("the fixed pattern stay"), std::string::npos) << note;
  EXPECT_EQ(recording.calibration.pmd.frequency.offset_m, 0.1);
  EXPECT_EQ(recording.calibration.pmd.lens.width, 4);
  EXPECT_TRUE(recording.calibration.pmd.fixed_pattern.empty());
}

TEST(FusionParams, OfAPresetAreThoseOfTheAppliance) {
  const auto params = fusion_params(preset("quality"), 96);
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->disparities, 96);
  EXPECT_EQ(params->subpixel, dsp::Subpixel::kEquiangular);
  EXPECT_TRUE(params->confidence);
  EXPECT_EQ(params->cost, lab::Cost::kAdCensus);
  EXPECT_EQ(params->method, lab::Method::kSemiGlobal);
  EXPECT_EQ(fusion_params(preset("fast", {{"subpixel", "parabola"}}), 64)->subpixel,
            dsp::Subpixel::kParabola);
}

TEST(FusionParams, OfAMethodAloneAreWholeAndChecked) {
  const auto params = fusion_params({.preset = "", .settings = {{"method", "so"}}}, 64);
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->method, lab::Method::kScanlineOptimisation);
  EXPECT_EQ(params->subpixel, dsp::Subpixel::kWhole);
  EXPECT_EQ(params->left_right_tolerance, 1);
  EXPECT_TRUE(params->confidence);
}

TEST(FusionParams, RefuseWhatIsNoMeasurement) {
  EXPECT_FALSE(fusion_params({.preset = "", .settings = {{"method", "sa"}}}, 64));
  EXPECT_FALSE(fusion_params({.preset = "", .settings = {{"fill", "on"}}}, 64));
  EXPECT_FALSE(fusion_params({.preset = "", .settings = {{"lr", "off"}}}, 64));
  EXPECT_FALSE(fusion_params(preset("best"), 64));
}

class FuseScene : public testing::Test {
 protected:
  static FusionResult fuse(const dataset::StereoScene& scene, double pmd_m,
                           const FusionOptions& options = {}) {
    const auto params = fusion_params({.preset = "", .settings = {{"block", "7x7"}}}, scene.ndisp);
    dataset::Loaded<FusionResult> result =
        fuse_scene(scene, test::flat_recording(pmd_m), *params, options);
    EXPECT_TRUE(result) << result.error().message;
    return *std::move(result);
  }
};

TEST_F(FuseScene, KeepsEachSensorAloneFreeOfTheOther) {
  const dataset::StereoScene scene = test::shifted_scene();
  const FusionResult near = fuse(scene, 2.0);
  const FusionResult far = fuse(scene, 2.4);
  EXPECT_EQ(near.stereo.depth.pixels, far.stereo.depth.pixels);
  EXPECT_NE(near.pmd.depth.pixels, far.pmd.depth.pixels);
  EXPECT_EQ(near.pmd.depth.pixels, fuse(test::shifted_scene(5), 2.0).pmd.depth.pixels);
  EXPECT_EQ(near.stereo.depth.pixels, fuse(scene, 2.0, {.guided = true}).stereo.depth.pixels);
}

TEST_F(FuseScene, SaysWhereEachDepthComesFrom) {
  const FusionResult result = fuse(test::shifted_scene(), 2.0);
  const auto sources = count_sources(result.source);
  std::size_t all = 0;
  for (const std::size_t count : sources) {
    all += count;
  }
  EXPECT_EQ(all, result.source.pixels.size());
  EXPECT_GT(sources[static_cast<std::size_t>(dsp::Source::kBoth)], all / 2);
  for (std::size_t i = 0; i < all; ++i) {
    const bool has_depth = std::isfinite(result.fused.depth.pixels[i]);
    const dsp::Source source = result.source.pixels[i];
    ASSERT_EQ(has_depth, source != dsp::Source::kNone && source != dsp::Source::kConflict);
  }
}

TEST_F(FuseScene, AnyNumberOfThreadsGivesTheSame) {
  const dataset::StereoScene scene = test::shifted_scene();
  const FusionResult alone = fuse(scene, 2.0, {.guided = true, .chapter_geometry = true});
  for (int threads = 2; threads <= dsp::ThreadTeam::kMost; ++threads) {
    const FusionResult result =
        fuse(scene, 2.0, {.guided = true, .chapter_geometry = true, .threads = threads});
    EXPECT_EQ(result.stereo.depth.pixels, alone.stereo.depth.pixels) << threads;
    EXPECT_EQ(result.fused.depth.pixels, alone.fused.depth.pixels) << threads;
    EXPECT_EQ(result.fused.low.pixels, alone.fused.low.pixels) << threads;
    EXPECT_EQ(result.fused.high.pixels, alone.fused.high.pixels) << threads;
    EXPECT_EQ(result.source.pixels, alone.source.pixels) << threads;
    EXPECT_EQ(result.cause.pixels, alone.cause.pixels) << threads;
    EXPECT_EQ(result.chapter->fused.depth.pixels, alone.chapter->fused.depth.pixels) << threads;
  }
}

TEST_F(FuseScene, MeasuresNothingBeyondTheRange) {
  const FusionResult result = fuse(test::shifted_scene(), 2.0, {.max_range = 7000});
  EXPECT_EQ(score_depth(result.fused, dataset::Image<float>(40, 30, 2)).coverage, 0);
}

TEST_F(FuseScene, OfTheChapterTakesTheRadialDistanceForDepth) {
  const FusionResult result = fuse(test::shifted_scene(), 2.0, {.chapter_geometry = true});
  ASSERT_TRUE(result.chapter);
  // A wall of one radial distance is flat there, and bent where geometry counts.
  const dataset::Image<float>& scaled = result.chapter->pmd.depth;
  const dataset::Image<float>& carried = result.pmd.depth;
  EXPECT_NEAR(scaled.view().at(20, 15), 2.0F, 0.02F);
  EXPECT_NEAR(scaled.view().at(1, 15), scaled.view().at(20, 15), 0.02F);
  EXPECT_LT(carried.view().at(1, 15), carried.view().at(20, 15) - 0.04F);
  EXPECT_FALSE(fuse(test::shifted_scene(), 2.0).chapter);
}

// A 3x2 PMD map that is enlarged twice.
struct Maps {
  std::array<dsp::QuarterMm, 6> distance{100, 200, 300, 400, 500, 0};
  std::array<dsp::QuarterMm, 6> low{90, 190, 290, 390, 490, 0};
  std::array<dsp::QuarterMm, 6> high{110, 210, 310, 410, 510, 0};
  std::array<std::uint8_t, 6> flags{0, dsp::kPmdEdge, 0, 0, 0, dsp::kPmdSaturated};
  dsp::PmdMaps view() {
    dsp::PmdMaps maps;
    maps.distance = {distance.data(), 3, 2};
    maps.low = {low.data(), 3, 2};
    maps.high = {high.data(), 3, 2};
    maps.flags = {flags.data(), 3, 2};
    return maps;
  }
};

dsp::Calibration twice() {
  dsp::Calibration calibration;
  calibration.stereo.left = {.width = 7, .height = 4, .fx = 4, .fy = 4, .cx = 2.5, .cy = 1.5};
  calibration.pmd.lens = {.width = 3, .height = 2, .fx = 2, .fy = 2, .cx = 1, .cy = 0.5};
  calibration.pmd_to_stereo.translation_m = {0.5, 0.5, 0.5};  // counts for nothing
  return calibration;
}

TEST(SplatByScaling, EnlargesTheMapAroundTheCentresAndDoesNothingElse) {
  Maps maps;
  dataset::Image<dsp::QuarterMm> nearest(7, 4);
  dataset::Image<dsp::QuarterMm> low(7, 4);
  dataset::Image<dsp::QuarterMm> high(7, 4);
  dataset::Image<std::uint8_t> flags(7, 4);
  splat_by_scaling(maps.view(), twice(), {nearest.view(), low.view(), high.view(), flags.view()});
  constexpr dsp::QuarterMm kNo = dsp::kNoSplat;
  EXPECT_EQ(low.pixels, (std::vector<dsp::QuarterMm>{90,  90,  190, 190, 290, 290, kNo,  //
                                                     90,  90,  190, 190, 290, 290, kNo,  //
                                                     390, 390, 490, 490, kNo, kNo, kNo,  //
                                                     390, 390, 490, 490, kNo, kNo, kNo}));
  EXPECT_EQ(high.view().at(0, 0), 110);
  EXPECT_EQ(high.view().at(4, 2), 0);
  EXPECT_EQ(nearest.view().at(3, 3), 500);
  EXPECT_EQ(flags.view().at(2, 1), dsp::kPmdEdge);
  EXPECT_EQ(flags.view().at(5, 3), 0);
}

}  // namespace
}  // namespace stof::host

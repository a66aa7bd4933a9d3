#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include <gtest/gtest.h>

#include "dsp/stereo/match_params.h"
#include "host/evaluate/stereo/disparity_score.h"
#include "host/evaluate/stereo/energy.h"
#include "host/evaluate/stereo/match.h"
#include "tests/support/random.h"
#include "tests/support/recorded_scenes.h"

// What stereo promises in numbers: on recorded pairs, where they are (the folder named by
// STOF_DATA), and on walls and noise made here. Figures are percent; every test prints its own.
namespace stof::host {
namespace {

using dataset::StereoScene;
using Settings = std::vector<std::pair<std::string, std::string>>;
using Share = std::optional<double> DisparityScore::*;

constexpr std::array<const char*, 4> kScenes{"Cones", "Teddy", "Tsukuba", "Venus"};
using Percents = std::array<double, kScenes.size()>;

MatchRequest method(Settings settings) {
  return {.preset = "", .settings = std::move(settings), .runs = 1};
}

MatchRequest preset(const std::string& name, Settings settings = {}) {
  return {.preset = name, .settings = std::move(settings), .runs = 1};
}

MatchResult match(const StereoScene& scene, const MatchRequest& options) {
  const std::expected<MatchPlan, dataset::Problem> plan = match_plan(options, scene.ndisp);
  if (!plan) {
    ADD_FAILURE() << plan.error().message;
    return {};
  }
  dataset::Loaded<MatchResult> result = match_scene(scene, *plan);
  if (!result) {
    ADD_FAILURE() << result.error().message;
    return {};
  }
  return *std::move(result);
}

DisparityScore score(const StereoScene& scene, const MatchRequest& options) {
  const MatchResult result = match(scene, options);
  return score_disparity(to_pixels(result.disparity.view()), scene, 1);
}

double percent(const std::optional<double>& share) {
  EXPECT_TRUE(share.has_value());
  return 100 * share.value_or(1);
}

// The same scene as a right camera of another exposure and response sees it.
StereoScene darkened(StereoScene scene) {
  for (std::uint8_t& grey : scene.right.pixels) {
    grey = static_cast<std::uint8_t>(std::lround(255 * std::pow(0.58 * grey / 255, 1.2)));
  }
  return scene;
}

dataset::Image<std::uint8_t> upper_left(const dataset::Image<std::uint8_t>& image, int width,
                                        int height) {
  dataset::Image<std::uint8_t> part{width, height};
  for (int y = 0; y < height; ++y) {
    std::ranges::copy(image.view().row(y).first(static_cast<std::size_t>(width)),
                      part.view().row(y).begin());
  }
  return part;
}

class StereoFigures : public test::RecordedScenes {
 protected:
  void SetUp() override {
    RecordedScenes::SetUp();
    if (IsSkipped()) {
      return;
    }
    for (const char* const name : kScenes) {
      dataset::Loaded<StereoScene> scene =
          dataset::read_stereo_scene(test::recorded_scenes() / "stereo" / name);
      ASSERT_TRUE(scene) << scene.error().message;
      ASSERT_TRUE(scene->truth && scene->visible) << name;
      scenes_.push_back(*std::move(scene));
    }
  }

  const StereoScene& tsukuba() const { return scenes_[2]; }

  void expect_at_most(const Percents& limits, const MatchRequest& options, Share share) const {
    std::printf("%s:", describe(options).c_str());
    for (std::size_t i = 0; i < kScenes.size(); ++i) {
      const double measured = percent(score(scenes_[i], options).*share);
      std::printf(" %s %.2f", kScenes[i], measured);
      EXPECT_LE(measured, limits[i]) << kScenes[i];
    }
    std::printf("\n");
  }

  void expect_density(double at_least, const MatchRequest& options,
                      std::span<const std::size_t> scenes) const {
    std::printf("%s, density:", describe(options).c_str());
    for (const std::size_t i : scenes) {
      const double density = percent(score(scenes_[i], options).density);
      std::printf(" %s %.2f", kScenes[i], density);
      EXPECT_GE(density, at_least) << kScenes[i];
    }
    std::printf("\n");
  }

  // By how much the bad share of what both cameras see rises when the right picture darkens.
  void expect_rise_at_most(double limit, const MatchRequest& options) const {
    std::printf("%s, darkened:", describe(options).c_str());
    for (const StereoScene& scene : scenes_) {
      const double rise =
          percent(score(darkened(scene), options).visible) - percent(score(scene, options).visible);
      std::printf(" %s %+.2f", scene.name.c_str(), rise);
      EXPECT_LE(rise, limit) << scene.name;
    }
    std::printf("\n");
  }

  std::vector<StereoScene> scenes_;  // as kScenes
};

TEST_F(StereoFigures, BlockMatchingOfDerivativesFindsWhatBothCamerasSee) {
  expect_at_most({7.0, 12.9, 6.6, 3.0},
                 method({{"method", "wta"}, {"cost", "sad"}, {"block", "16x16"}}),
                 &DisparityScore::visible);
}

TEST_F(StereoFigures, ScanlineOptimisationFindsWhatBothCamerasSee) {
  expect_at_most({7.3, 10.7, 4.0, 2.7}, method({{"method", "so"}}), &DisparityScore::visible);
}

TEST_F(StereoFigures, OrderedMatchingFindsWhatBothCamerasSee) {
  expect_at_most({7.3, 10.7, 4.0, 2.7}, method({{"method", "dp"}}), &DisparityScore::visible);
}

TEST_F(StereoFigures, QualityFilledFindsWhatBothCamerasSee) {
  expect_at_most({3.8, 7.0, 3.4, 1.4}, preset("quality", {{"fill", "on"}}),
                 &DisparityScore::visible);
}

TEST_F(StereoFigures, QualityFilledFindsMostOfThePicture) {
  expect_at_most({11.5, 15.0, 4.6, 3.8}, preset("quality", {{"fill", "on"}}), &DisparityScore::all);
}

TEST_F(StereoFigures, QualityIsRightWhereItAnswers) {
  expect_at_most({4.5, 7.5, 3.8, 2.2}, preset("quality"), &DisparityScore::of_valid);
}

TEST_F(StereoFigures, QualityAnswersForMostOfEveryPicture) {
  expect_density(85, preset("quality"), std::array<std::size_t, 4>{0, 1, 2, 3});
}

TEST_F(StereoFigures, FastAnswersForMostOfTexturedPictures) {
  expect_density(85, preset("fast"), std::array<std::size_t, 3>{0, 1, 3});
}

TEST_F(StereoFigures, BlockMatchingOfDerivativesBearsAnotherBrightness) {
  expect_rise_at_most(2, method({{"method", "wta"}, {"cost", "sad"}, {"block", "16x16"}}));
}

TEST_F(StereoFigures, QualityBearsAnotherBrightness) { expect_rise_at_most(2, preset("quality")); }

TEST_F(StereoFigures, QualityFilledBearsAnotherBrightness) {
  expect_rise_at_most(2, preset("quality", {{"fill", "on"}}));
}

TEST_F(StereoFigures, RegionBlocksFattenEdgesLessThanFixedBlocks) {
  for (const StereoScene& scene : scenes_) {
    const double fixed = percent(score(scene, method({{"block", "60x20"}})).near_edges);
    const double region =
        percent(score(scene, method({{"shape", "region"}, {"block", "60x20"}})).near_edges);
    std::printf("%s near edges: fixed %.2f region %.2f\n", scene.name.c_str(), fixed, region);
    EXPECT_LT(region, fixed) << scene.name;
  }
}

// Too small a disparity is no error there, so the chapter's number flatters.
TEST_F(StereoFigures, ChaptersReadingOfBadPixelsStandsBesideTheUsualOne) {
  for (const StereoScene& scene : scenes_) {
    const DisparityScore found = score(scene, method({{"method", "wta"}}));
    std::printf("%s signed: all %.2f visible %.2f\n", scene.name.c_str(), percent(found.signed_all),
                percent(found.signed_visible));
    EXPECT_LT(percent(found.signed_all), percent(found.all)) << scene.name;
    EXPECT_LT(percent(found.signed_visible), percent(found.visible)) << scene.name;
  }
}

TEST_F(StereoFigures, AnnealingEndsNotAboveScanlineOptimisation) {
  MatchRequest scanline = method({{"method", "so"}});
  scanline.energy = true;
  const std::optional<std::uint64_t> rows = match(tsukuba(), scanline).energy;
  const std::optional<std::uint64_t> annealed = match(tsukuba(), method({{"method", "sa"}})).energy;
  ASSERT_TRUE(rows && annealed);
  std::printf("energy: so %llu sa %llu\n", static_cast<unsigned long long>(*rows),
              static_cast<unsigned long long>(*annealed));
  EXPECT_LE(*annealed, *rows);
}

TEST_F(StereoFigures, AnnealingRepeatsItselfForASeedAndBeatsHillClimbing) {
  StereoScene part = tsukuba();
  part.left = upper_left(part.left, 160, 100);
  part.right = upper_left(part.right, 160, 100);
  MatchRequest options = method({{"method", "sa"}});
  options.seed = 7;
  const MatchResult first = match(part, options);
  const MatchResult second = match(part, options);
  EXPECT_EQ(first.energy, second.energy);
  EXPECT_EQ(first.disparity.pixels, second.disparity.pixels);

  options.hill_climbing = true;
  const MatchResult climbed = match(part, options);
  ASSERT_TRUE(first.energy && climbed.energy);
  EXPECT_LT(*first.energy, *climbed.energy);
  MatchRequest start = method({{"block", "5x5"}});
  start.energy = true;
  EXPECT_LT(*climbed.energy, match(part, start).energy);
}

StereoScene empty_scene(int width, int height, int disparities) {
  StereoScene scene;
  scene.left = {width, height};
  scene.right = {width, height};
  scene.ndisp = disparities;
  return scene;
}

// A wall of one colour, or of one that rises from the left to the right, seen by two cameras whose
// noise is normal (nearly: the sum of twelve uniform numbers) with sigma 2 grey levels.
StereoScene noisy_wall(int rise, std::uint64_t seed) {
  constexpr int kOne = 65536;  // a grey level, and the sigma of a sum of twelve of 0..65535
  constexpr int kSigma = 2;
  StereoScene scene = empty_scene(320, 240, 64);
  test::Random random(seed);
  for (dataset::Image<std::uint8_t>* const image : {&scene.left, &scene.right}) {
    for (int y = 0; y < image->height; ++y) {
      for (int x = 0; x < image->width; ++x) {
        int noise = -6 * (kOne - 1);
        for (int i = 0; i < 12; ++i) {
          noise += random.between(0, kOne - 1);
        }
        const int grey = 100 * kOne + rise * kOne / image->width * x + kSigma * noise;
        image->view().row(y)[static_cast<std::size_t>(x)] =
            static_cast<std::uint8_t>((grey + kOne / 2) / kOne);
      }
    }
  }
  return scene;
}

double valid_percent(const MatchResult& result) {
  return 100.0 *
         static_cast<double>(
             std::ranges::count_if(result.disparity.pixels, &dsp::Disparity::valid)) /
         static_cast<double>(result.disparity.pixels.size());
}

void expect_silence(const char* name, int rise) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const StereoScene wall = noisy_wall(rise, seed);
    const double valid = valid_percent(match(wall, preset(name)));
    std::printf("%s, wall rising by %d, seed %llu: %.2f valid\n", name, rise,
                static_cast<unsigned long long>(seed), valid);
    EXPECT_LE(valid, 2) << "seed " << seed;
  }
}

TEST(NoisyWall, GivesFastNothing) { expect_silence("fast", 0); }
TEST(NoisyWall, GivesFastNothingWhereItShades) { expect_silence("fast", 60); }
TEST(NoisyWall, GivesQualityNothing) { expect_silence("quality", 0); }
TEST(NoisyWall, GivesQualityNothingWhereItShades) { expect_silence("quality", 60); }

StereoScene noise(int width, int height, int disparities) {
  StereoScene scene = empty_scene(width, height, disparities);
  test::Random random(static_cast<std::uint64_t>(width * 4096 + height));
  random.fill(std::span(scene.left.pixels), 0, 255);
  random.fill(std::span(scene.right.pixels), 0, 255);
  return scene;
}

void expect_sound(const StereoScene& scene, const MatchRequest& options) {
  const MatchResult result = match(scene, options);
  ASSERT_EQ(result.disparity.width, scene.left.width);
  ASSERT_EQ(result.disparity.height, scene.left.height);
  const int least = -dsp::Disparity::kOne / 2;  // fits move by half a pixel at most
  const int most = (scene.ndisp - 1) * dsp::Disparity::kOne + dsp::Disparity::kOne / 2;
  for (const dsp::Disparity d : result.disparity.pixels) {
    ASSERT_TRUE(!d.valid() || (d.raw >= least && d.raw <= most))
        << scene.left.width << "x" << scene.left.height << ": " << d.raw;
  }
}

TEST(AnySize, OfNoiseGivesDisparitiesWithinTheRange) {
  constexpr std::array<std::pair<int, int>, 8> kSizes{
      {{1, 1}, {1, 720}, {1280, 1}, {2, 2}, {7, 5}, {17, 33}, {64, 3}, {200, 31}}};
  for (const auto& [width, height] : kSizes) {
    for (const int disparities : {1, 64, 128}) {
      for (const char* const name : {"fast", "quality"}) {
        expect_sound(noise(width, height, disparities), preset(name));
        expect_sound(noise(width, height, disparities), preset(name, {{"fill", "on"}}));
      }
    }
  }
}

TEST(AnySize, Of1280x720IsNotTooLargeForFast) {
  expect_sound(noise(1280, 720, 128), preset("fast"));
}

TEST(AnySize, Of1280x720IsNotTooLargeForQuality) {
  expect_sound(noise(1280, 720, 128), preset("quality"));
}

}  // namespace
}  // namespace stof::host

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>

#include <gtest/gtest.h>

#include "host/evaluate/fusion/fusion_case.h"
#include "tests/support/recorded_scenes.h"

// What fusion promises in numbers, on recorded pairs with simulated PMD cameras, where they are:
// the folder named by STOF_DATA. Every test prints its own figures.
namespace stof::host {
namespace {

const std::vector<std::string> kFour{"Teddy", "Cones", "Venus", "Tsukuba"};
const std::string kSmall = "64x16";
const std::string kLarge = "176x144";

using Match = std::string;  // a preset; empty: winner takes all with the left-right check

// Each case is computed once for all tests.
const FusionCase& fused(const Match& match, const std::string& scene, const std::string& sensor) {
  static std::map<std::string, FusionCase> done;
  const std::string key = match + "/" + scene + "/" + sensor;
  const auto found = done.find(key);
  if (found != done.end()) {
    return found->second;
  }
  const std::filesystem::path data = test::recorded_scenes();
  const std::filesystem::path pair =
      scene == "Plastic" ? data / "tof" / "scenes" / scene : data / "stereo" / scene;
  const std::filesystem::path prefix = data / "tof" / "sim" / "scene" / (scene + "_" + sensor);
  dataset::Loaded<FusionCase> result =
      run_fusion_case(pair, prefix, {.preset = match, .settings = {}, .runs = 1}, {});
  if (!result) {
    ADD_FAILURE() << result.error().message;
    result.emplace();
  }
  return done.emplace(key, *std::move(result)).first->second;
}

class FusionFigures : public test::RecordedScenes {
 protected:
  static double mean_e5(const Match& match, const std::string& sensor) {
    double sum = 0;
    for (const std::string& scene : kFour) {
      const FusionScores& scores = fused(match, scene, sensor).scores;
      std::printf("%s %s %s: pmd %.4f, stereo %.4f, fused %.4f\n", match.c_str(), scene.c_str(),
                  sensor.c_str(), scores.pmd.e5, scores.stereo.e5, scores.fused.e5);
      sum += scores.fused.e5;
    }
    std::printf("%s mean %s: fused %.4f\n", match.c_str(), sensor.c_str(),
                sum / static_cast<double>(kFour.size()));
    return sum / static_cast<double>(kFour.size());
  }

  static double plastic_e5(const Match& match, const std::string& sensor) {
    const double e5 = fused(match, "Plastic", sensor).scores.fused.e5;
    std::printf("%s Plastic %s: fused %.4f\n", match.c_str(), sensor.c_str(), e5);
    return e5;
  }

  template <typename Visit>
  static void each_case(const Match& match, Visit visit) {
    for (const std::string& sensor : {kSmall, kLarge}) {
      for (const std::string& scene : kFour) {
        visit(fused(match, scene, sensor));
      }
      visit(fused(match, "Plastic", sensor));
    }
  }

  static void expect_honest(const Match& match) {
    double sum = 0;
    int cases = 0;
    std::map<std::string, std::vector<IntervalCheck>> pooled;
    each_case(match, [&](const FusionCase& each) {
      const std::string name = match + " " + each.recording;
      const double rate = each.scores.fused.hit_rate.value_or(0);
      std::printf("%s: truth inside %.4f\n", name.c_str(), rate);
      EXPECT_GE(rate, kLeast) << name;
      sum += rate;
      ++cases;
      for (const std::string& pool : {std::string("all"), each.sensor()}) {
        const std::vector<IntervalCheck> checks = check_intervals(each.result.fused, each.truth);
        pooled[pool].insert(pooled[pool].end(), checks.begin(), checks.end());
      }
    });
    std::printf("%s mean: %.4f\n", match.c_str(), sum / cases);
    EXPECT_GE(sum / cases, 0.93) << match;
    EXPECT_LE(sum / cases, 0.98) << match;
    for (const auto& [pool, checks] : pooled) {
      std::printf("%s quarters of width, %s:", match.c_str(), pool.c_str());
      for (const std::optional<double>& rate : hit_rates_by_width(checks, kWidthParts)) {
        std::printf(" %.4f", rate.value_or(0));
        EXPECT_TRUE(pool != "all" || (rate >= 0.88 && rate <= 0.99)) << match;
      }
      std::printf("\n");
    }
  }

 private:
  static constexpr double kLeast = 0.90;
};

TEST_F(FusionFigures, DepthOfASimpleSearchIsRight) {
  EXPECT_LE(mean_e5("", kSmall), 0.100);
  EXPECT_LE(mean_e5("", kLarge), 0.065);
  EXPECT_LE(plastic_e5("", kSmall), 0.300);
  EXPECT_LE(plastic_e5("", kLarge), 0.102);
}

TEST_F(FusionFigures, DepthOfQualityIsRight) {
  EXPECT_LE(mean_e5("quality", kSmall), 0.062);
  EXPECT_LE(mean_e5("quality", kLarge), 0.045);
  EXPECT_LE(plastic_e5("quality", kSmall), 0.200);
  EXPECT_LE(plastic_e5("quality", kLarge), 0.086);
}

TEST_F(FusionFigures, DepthOfBothSensorsIsBetterThanOfEach) {
  for (const char* const match : {"", "fast", "quality"}) {
    each_case(match, [match](const FusionCase& each) {
      const FusionScores& scores = each.scores;
      EXPECT_LT(scores.fused.e5, scores.pmd.e5) << match << " " << each.recording;
      EXPECT_LT(scores.fused.e5, scores.stereo.e5) << match << " " << each.recording;
    });
  }
}

TEST_F(FusionFigures, IntervalsOfASimpleSearchAreHonest) { expect_honest(""); }
TEST_F(FusionFigures, IntervalsOfQualityAreHonest) { expect_honest("quality"); }

TEST_F(FusionFigures, IntervalsAreNarrow) {
  for (const char* const match : {"", "quality"}) {
    for (const std::string& sensor : {kSmall, kLarge}) {
      double sum = 0;
      for (const std::string& scene : kFour) {
        const double width =
            fused(match, scene, sensor).scores.fused.median_width_relative.value_or(1);
        std::printf("%s %s %s: median width %.4f of the depth\n", match, scene.c_str(),
                    sensor.c_str(), width);
        sum += width;
      }
      EXPECT_LE(sum / static_cast<double>(kFour.size()), 0.04) << match << " " << sensor;
    }
  }
}

std::string recording_of(const std::string& scene, const std::string& sensor) {
  return scene + "_" + sensor;
}

TEST_F(FusionFigures, FullGeometryGainsOverAScaledMap) {
  for (const std::string& sensor : {kSmall, kLarge}) {
    double scaled = 0;
    double full = 0;
    for (const std::string& scene : kFour) {
      const std::filesystem::path data = test::recorded_scenes();
      const dataset::Loaded<FusionCase> result = run_fusion_case(
          data / "stereo" / scene, data / "tof" / "sim" / "scene" / recording_of(scene, sensor),
          {.preset = "", .settings = {}, .runs = 1}, {.chapter_geometry = true});
      ASSERT_TRUE(result) << result.error().message;
      scaled += result->scores.chapter_fused->e5 / static_cast<double>(kFour.size());
      full += result->scores.reprojected->e5 / static_cast<double>(kFour.size());
    }
    std::printf("%s, interval rule: scaled %.4f, full geometry %.4f\n", sensor.c_str(), scaled,
                full);
    EXPECT_LT(full, scaled) << sensor;
  }
}

}  // namespace
}  // namespace stof::host

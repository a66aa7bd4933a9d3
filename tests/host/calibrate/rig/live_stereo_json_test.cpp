#include "host/cli/rig/live_stereo_json.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "host/calibrate/rig/report/rig_report.h"
#include "host/cli/rig/stereo_json.h"

namespace stof::host {
namespace {

using Json = nlohmann::ordered_json;

TargetCalibration good() {
  TargetCalibration found;
  found.fit.corner_sigma_px = 0.05;
  found.fit.rig.left_to_right.translation_m = {-0.12, 0, 0};
  found.fit.covariance = Eigen::MatrixXd::Zero(kRigUnknowns, kRigUnknowns);
  found.held_out.resize(4);
  found.judgement = TargetJudgement{.views = 4,
                                    .reprojection_px = 0.06,
                                    .row_px = 0.1,
                                    .largest_row_px = 0.3,
                                    .scale_error = -0.001};
  return found;
}

Json result_json(const TargetCalibration& found) {
  CalibStereoOptions options;
  options.out = "rig.cal";
  return target_json(options, "views", found);
}

TEST(LiveStereoJson, ALookHasOneEntryForEachCornerThatIsSeenAndNoNaN) {
  const RawShot shot{.exposure = 7, .left = {16, 12}, .right = {16, 12}, .pmd = {}};
  const PairView corners{.name = "view_001", .left = {{1.234, 2}, kUnseen, {3, 4}}, .right = {}};
  const ViewGuide guide({.width = 16, .height = 12, .views = 5});
  const ViewJudgement judgement{.verdict = ViewVerdict::kMoving};
  const Json json = look_json(
      {.shot = shot, .corners = corners, .judgement = judgement, .guide = guide, .text = "hold"},
      0);
  EXPECT_EQ(json["left"], Json::parse("[[1.23,2.0],[3.0,4.0]]"));
  EXPECT_EQ(json["right"], Json::array());
  EXPECT_EQ(json["verdict"], "moving");
  EXPECT_TRUE(json["motion_px"].is_null());
  EXPECT_EQ(json["wants"].back()["need"], 5);
  EXPECT_FALSE(json.contains("left_png"));
  EXPECT_EQ(json["cells"]["right"].size(), 48U);
}

TEST(LiveStereoJson, PicturesAreMadeSmallerByTheMeanOfBlocks) {
  dataset::Image<std::uint8_t> picture(5, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    picture.pixels[i] = static_cast<std::uint8_t>(10 * i);
  }
  const dataset::Image<std::uint8_t> small = smaller_picture(picture, 2);
  ASSERT_EQ(small.width, 2);
  ASSERT_EQ(small.height, 1);
  EXPECT_EQ(small.pixels[0], (0 + 10 + 50 + 60) / 4);
  EXPECT_EQ(small.pixels[1], (20 + 30 + 70 + 80) / 4);
  EXPECT_EQ(smaller_picture(picture, 1).pixels, picture.pixels);
}

TEST(LiveStereoJson, AGoodCalibrationHasNoWarning) {
  const Json json = result_json(good());
  EXPECT_EQ(json["warnings"], Json::array());
  EXPECT_EQ(json["file"], "rig.cal");
  EXPECT_NEAR(json["baseline_m"].get<double>(), 0.12, 1e-12);
  EXPECT_EQ(json["held_out"]["views"].size(), 4U);
}

TEST(LiveStereoJson, EachThingThatIsWrongIsAWarningInWords) {
  TargetCalibration found = good();
  found.fit.corner_sigma_px = 0.8;
  found.judgement->row_px = 0.5;
  found.judgement->scale_error = 0.011;
  found.refused = {{"view_003", "it is blurred"}};
  found.missing = {"tilted: more"};
  const Json json = result_json(found);
  ASSERT_EQ(json["warnings"].size(), 5U);
  EXPECT_EQ(json["warnings"][0], "tilted: more");
  EXPECT_NE(json["warnings"][1].get<std::string>().find("off by 0.80 px"), std::string::npos);
  EXPECT_NE(json["warnings"][2].get<std::string>().find("apart by 0.50 px"), std::string::npos);
  EXPECT_NE(json["warnings"][3].get<std::string>().find("1.10 percent too large"),
            std::string::npos);
  EXPECT_EQ(json["warnings"][4], "view_003 was left out: it is blurred");
  found = good();
  found.judgement->reprojection_px = 0.53;
  found.notes = {"the baseline is another one"};
  const Json off = result_json(found);
  ASSERT_EQ(off["warnings"].size(), 2U);
  EXPECT_NE(off["warnings"][0].get<std::string>().find("off by 0.53 px"), std::string::npos);
  EXPECT_EQ(off["warnings"][1], "the baseline is another one");
  // People read the same.
  const std::string text = target_text(found);
  EXPECT_NE(text.find("note: corners are off by 0.53 px"), std::string::npos) << text;
  EXPECT_NE(text.find("note: the baseline is another one\n"), std::string::npos) << text;
  found = good();
  EXPECT_EQ(target_text(found).find("note: "), std::string::npos);
  found.judgement.reset();
  const Json unjudged = result_json(found);
  EXPECT_TRUE(unjudged["held_out"].is_null());
  ASSERT_EQ(unjudged["warnings"].size(), 1U);
  EXPECT_NE(unjudged["warnings"][0].get<std::string>().find("nobody judges"), std::string::npos);
}

}  // namespace
}  // namespace stof::host

#include "dataset/calibration_truth.h"

#include "dataset/files/json_file.h"
#include "tests/dataset/scratch.h"

namespace stof::dataset {
namespace {

class CalibrationTruths : public test::Scratch {};

TEST_F(CalibrationTruths, ReadBackEqualToEveryBit) {
  const double third = 1.0 / 3;
  CalibrationTruth truth;
  truth.left = {.width = 640,
                .height = 480,
                .fx = 600 + third,
                .fy = 601,
                .cx = 320,
                .cy = 240,
                .k1 = -third,
                .k2 = 0.1,
                .k3 = 0.01,
                .p1 = 1e-3,
                .p2 = -1e-17};
  truth.right = truth.left;
  truth.right.cx = 311;
  truth.left_to_right = {.rotation = {0, -1, 0, 1, 0, 0, 0, 0, 1}, .translation_m = {-third, 0, 7}};
  truth.pmd = dsp::Pinhole{.width = 64, .height = 16, .fx = 45, .fy = 45};
  truth.blur_px = 0.7;
  truth.board = BoardTruth{.kind = "chess", .columns = 9, .rows = 6, .square_m = 0.04};
  truth.poses.push_back({.folder = "pose_000",
                         .kind = "near",
                         .board_to_left = {.rotation = {1, 0, 0, 0, 0, 1, 0, -1, 0},
                                           .translation_m = {0.1, 0.2, third}},
                         .velocity_m_s = {third, 0, 0},
                         .seen_by_right = true});
  ASSERT_TRUE(write_calibration_truth(folder() / "truth.json", truth));
  const Loaded<nlohmann::json> read = read_object(folder() / "truth.json");
  ASSERT_TRUE(read) << read.error().message;
  const nlohmann::json& root = *read;
  EXPECT_EQ(root["version"], 1);
  EXPECT_EQ(root["left"]["fx"], 600 + third);
  EXPECT_EQ(root["left"]["k1"], -third);
  EXPECT_EQ(root["left"]["p2"], -1e-17);
  EXPECT_EQ(root["right"]["cx"], 311.0);
  EXPECT_EQ(root["left_to_right"]["T"][0], -third);
  EXPECT_EQ(root["left_to_right"]["R"][1], -1.0);
  EXPECT_EQ(root["pmd"]["width"], 64);
  EXPECT_FALSE(root.contains("converging"));
  const nlohmann::json& pose = root["poses"][0];
  EXPECT_EQ(pose["folder"], "pose_000");
  EXPECT_EQ(pose["velocity_m_s"][0], third);
  // The z axis of the board is (0, 1, 0), so the sheet is 0.2 m along it.
  EXPECT_EQ(pose["plane"]["normal"], (nlohmann::json{0.0, 1.0, 0.0}));
  EXPECT_EQ(pose["plane"]["distance_m"], 0.2);
  EXPECT_EQ(pose["seen_by"]["right"], true);
  EXPECT_EQ(pose["seen_by"]["pmd"], false);
}

TEST_F(CalibrationTruths, AreRefusedWhereTheyCannotBeWritten) {
  const auto written = write_calibration_truth(folder() / "nowhere" / "truth.json", {});
  ASSERT_FALSE(written);
  test::expect_one_line_about(written.error().message, folder() / "nowhere" / "truth.json", "");
}

}  // namespace
}  // namespace stof::dataset

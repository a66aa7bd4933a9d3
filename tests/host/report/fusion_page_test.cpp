#include "host/report/fusion/fusion_page.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "host/report/fusion/fusion_figures.h"
#include "host/report/fusion/fusion_summary.h"
#include "tests/host/evaluate/fusion_scene.h"

namespace stof::host {
namespace {

FusionCase wall(double pmd_m, bool chapter) {
  dataset::StereoScene scene = test::shifted_scene();
  const dataset::PmdRecording recording = test::flat_recording(pmd_m);
  const auto params = fusion_params({.preset = "", .settings = {{"block", "7x7"}}}, scene.ndisp);
  FusionResult result =
      *fuse_scene(scene, recording, *params, {.chapter_geometry = chapter, .runs = 1});
  FusionCase fused{.scene = scene.name,
                   .recording = "wall_4x2",
                   .lens = recording.calibration.pmd.lens,
                   .rig = recording.calibration.stereo,
                   .left = scene.left,
                   .truth = depth_from_disparity(*scene.truth, recording.calibration.stereo),
                   .note = {},
                   .result = std::move(result),
                   .scores = {}};
  fused.scores = score_fusion(fused.result, fused.truth);
  return fused;
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) {
    ++found;
  }
  return found;
}

class FusionPage : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "stof_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string page(std::span<const FusionCase> cases) const {
    const std::filesystem::path file = folder_ / "new" / "page.html";
    const auto written = write_fusion_page(cases, "wta <7x7>", file);
    EXPECT_TRUE(written) << written.error().message;
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }

  std::filesystem::path folder_;
};

TEST_F(FusionPage, ShowsAPairOnceAndEachOfItsRecordings) {
  std::vector<FusionCase> cases;
  cases.push_back(wall(2.0, true));
  cases.push_back(wall(2.1, true));
  const std::string text = page(cases);
  for (const char* const id : {"summary", "intervals", "geometry", "scene-1"}) {
    EXPECT_EQ(count(text, "<section id=\"" + std::string(id) + "\">"), 1U) << id;
  }
  EXPECT_EQ(count(text, "scene-2"), 0U);
  EXPECT_EQ(count(text, "Stereo alone, errors"), 2U);  // one figure: its name and its caption
  EXPECT_EQ(count(text, "Source of the depth"), 4U);
  EXPECT_EQ(count(text, "<figure>"),
            count(text, "data:image/png;base64,") + count(text, "<svg class=\"plot\""));
  EXPECT_EQ(count(text, "Wall & co"), 0U);
  EXPECT_EQ(count(text, "wta &lt;7x7&gt;"), 1U);
  EXPECT_EQ(count(text, "<script") + count(text, "http"), 0U);
}

TEST_F(FusionPage, HasNoGeometrySectionUnlessAskedFor) {
  std::vector<FusionCase> cases;
  cases.push_back(wall(2.0, false));
  EXPECT_EQ(count(page(cases), "<section id=\"geometry\">"), 0U);
}

TEST_F(FusionPage, JudgesClaimsByWhatWasMeasured) {
  std::vector<FusionCase> cases;
  cases.push_back(wall(2.0, false));
  FusionScores& scores = cases.front().scores;
  const auto verdict = [&cases] {
    Page page;
    add_fusion_summary(cases, page);
    return page.verdicts();
  };
  scores.pmd.e5 = 0.3;
  scores.stereo.e5 = 0.2;
  scores.fused.e5 = 0.1;
  EXPECT_TRUE(verdict().starts_with("yes ")) << verdict();
  scores.fused.e5 = 0.2;
  EXPECT_TRUE(verdict().starts_with("no ")) << verdict();
}

TEST_F(FusionPage, WithoutAPlaceToGoIsOneLine) {
  std::ofstream(folder_ / "file") << "x";
  std::vector<FusionCase> cases;
  cases.push_back(wall(2.0, false));
  const auto written = write_fusion_page(cases, "", folder_ / "file" / "page.html");
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("cannot be written"), std::string::npos);
}

TEST(FusionScales, SpanTheTruth) {
  const FusionScales scales = scales_of(wall(2.0, false));
  EXPECT_LT(scales.depth.near_m, 2.0);
  EXPECT_GT(scales.depth.far_m, 2.0);
  EXPECT_LT(scales.disparity.far_px, 3.0);
  EXPECT_GT(scales.disparity.near_px, 3.0);
}

}  // namespace
}  // namespace stof::host

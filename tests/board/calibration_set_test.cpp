#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "board/emu/emu_options.h"
#include "board/emu/rig_flags.h"
#include "board/emu/scenes.h"
#include "board/emu/write_pair.h"
#include "dataset/dataset.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using Words = std::vector<std::string_view>;
using nlohmann::json;

class CalibrationSet : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  int run(const Words& more) const {
    Words words{text_};
    words.insert(words.end(), more.begin(), more.end());
    return board::write_pair(words);
  }
  json truth() const { return json::parse(std::ifstream(folder_ / "truth.json")); }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("stof_set_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  std::string text_ = folder_.string();
};

double number(const json& value) { return value.get<double>(); }

using Point = std::array<double, 3>;

Point moved(const json& transform, const Point& p) {
  Point out{};
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = number(transform["T"][i]);
    for (std::size_t k = 0; k < 3; ++k) {
      out[i] += number(transform["R"][3 * i + k]) * p[k];
    }
  }
  return out;
}

Point moved_back(const json& transform, const Point& p) {
  Point out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      out[i] += number(transform["R"][3 * k + i]) * (p[k] - number(transform["T"][k]));
    }
  }
  return out;
}

// Brown's model of a lens of truth.json.
std::array<double, 2> pixel_of(const json& lens, const Point& p) {
  const auto n = [&](const char* key) { return number(lens[key]); };
  const double x = p[0] / p[2];
  const double y = p[1] / p[2];
  const double r2 = x * x + y * y;
  const double radial = 1 + n("k1") * r2 + n("k2") * r2 * r2 + n("k3") * r2 * r2 * r2;
  return {n("fx") * (x * radial + 2 * n("p1") * x * y + n("p2") * (r2 + 2 * x * x)) + n("cx"),
          n("fy") * (y * radial + n("p1") * (r2 + 2 * y * y) + 2 * n("p2") * x * y) + n("cy")};
}

// How many inner corners of a board have dark and bright squares where the truth says: the levels
// in the middles of the four squares around each.
template <typename Level>
int corners_found(const json& board, const json& to_camera, const json& lens, const Level& level) {
  int found = 0;
  const double square = number(board["square_m"]);
  for (int j = 0; j < board["rows"].get<int>(); ++j) {
    for (int i = 0; i < board["columns"].get<int>(); ++i) {
      std::array<double, 4> around{};
      for (std::size_t k = 0; k < 4; ++k) {
        const double dx = k % 2 == 0 ? -0.5 : 0.5;
        const double dy = k < 2 ? -0.5 : 0.5;
        const auto at = pixel_of(lens, moved(to_camera, {(i + dx) * square, (j + dy) * square, 0}));
        around[k] =
            level(static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])));
      }
      const bool dark_first = (i + j) % 2 == 0;
      const double dark = std::max(around[dark_first ? 0 : 1], around[dark_first ? 3 : 2]);
      const double bright = std::min(around[dark_first ? 1 : 0], around[dark_first ? 2 : 3]);
      found += 2 * dark < bright ? 1 : 0;
    }
  }
  return found;
}

json after(const json& first, const json& second) {  // X -> second(first(X))
  json out{{"R", json::array()}, {"T", json::array()}};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      double sum = 0;
      for (std::size_t m = 0; m < 3; ++m) {
        sum += number(second["R"][3 * i + m]) * number(first["R"][3 * m + k]);
      }
      out["R"].push_back(sum);
    }
  }
  const Point t =
      moved(second, {number(first["T"][0]), number(first["T"][1]), number(first["T"][2])});
  out["T"] = {t[0], t[1], t[2]};
  return out;
}

// The judge's reading: truth.json alone, with the formula written out once more, tells where every
// corner of every picture is, in grey values and in the PMD camera's amplitude.
TEST_F(CalibrationSet, ShowsItsBoardWhereItsTruthSays) {
  ASSERT_EQ(run({"--scene", "board:chess,7x5,0.05", "--poses", "wave:5,4", "--misbuilt", "5",
                 "--blur", "0.6", "--frames", "2"}),
            0);
  const json all = truth();
  EXPECT_EQ(all["version"], 1);
  EXPECT_EQ(all["poses"].size(), 5U);
  const double cosine =
      (number(all["left_to_right"]["R"][0]) + number(all["left_to_right"]["R"][4]) +
       number(all["left_to_right"]["R"][8]) - 1) /
      2;
  EXPECT_NEAR(std::acos(cosine) * 180 / 3.14159265358979, 2, 1e-6);
  EXPECT_NEAR(number(all["right"]["cy"]) - number(all["left"]["cy"]), 3, 1e-9);
  for (const json& pose : all["poses"]) {
    const std::filesystem::path folder = folder_ / pose["folder"].get<std::string>();
    const auto pair = dataset::read_stereo_scene(folder);
    ASSERT_TRUE(pair) << pair.error().message;
    EXPECT_FALSE(pair->truth || pair->rig || pair->visible) << "a solver would read it";
    const json& board = all["board"];
    const json& to_left = pose["board_to_left"];
    const auto grey = [](const dataset::Image<std::uint8_t>& picture) {
      return [&picture](int x, int y) { return picture.view().at(x, y) - 4.0; };
    };
    EXPECT_EQ(corners_found(board, to_left, all["left"], grey(pair->left)), 35) << folder;
    EXPECT_EQ(
        corners_found(board, after(to_left, all["left_to_right"]), all["right"], grey(pair->right)),
        35)
        << folder;
    const auto recording = dataset::read_pmd(folder / "pmd");
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_FALSE(recording->has_rig);
    ASSERT_EQ(recording->frames.size(), 2U);
    if (!pose["seen_by"]["pmd"].get<bool>()) {
      continue;
    }
    const auto samples = recording->samples(0);
    const auto amplitude = [&](int x, int y) {
      const double i = samples[0].at(x, y) - samples[2].at(x, y);
      const double q = samples[3].at(x, y) - samples[1].at(x, y);
      EXPECT_LT(samples[0].at(x, y), 4095) << "saturated";
      return std::hypot(i, q);
    };
    const json& pmd = all["pmd_to_left"];
    const Point t = moved_back(pmd, {0, 0, 0});
    json back{{"R", json::array()}, {"T", {t[0], t[1], t[2]}}};
    for (std::size_t i = 0; i < 9; ++i) {
      back["R"].push_back(pmd["R"][3 * (i % 3) + i / 3]);
    }
    // At 176x144 squares of a far board are 4 px wide, and noise is large.
    EXPECT_GE(corners_found(board, after(to_left, back), all["pmd"], amplitude), 33) << folder;
  }
}

TEST_F(CalibrationSet, OfAPlaneSaysItsDistance) {
  ASSERT_EQ(run({"--scene", "plane", "--poses", "distances:1.6,2.5", "--rig", "chapter", "--size",
                 "160x120"}),
            0);
  const json all = truth();
  EXPECT_EQ(all["board"]["kind"], "plane");
  EXPECT_NEAR(number(all["converging"]["alpha_rad"]), std::atan(0.1 / 4), 1e-12);
  const auto scene = dataset::read_stereo_scene(folder_ / "pose_001");
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->plane_z_m, 2.5);
  // The left camera is turned by that angle, so the plane is nearer along its axis.
  const json& plane = all["poses"][1]["plane"];
  EXPECT_NEAR(number(plane["distance_m"]), 2.5, 1e-12);
  EXPECT_NEAR(number(plane["normal"][0]), -std::sin(std::atan(0.1 / 4)), 1e-12);
}

TEST_F(CalibrationSet, IsTheSameEachTimeAndAnotherWithAnotherSeed) {
  const Words words{"--scene", "board:chess,5x4,0.06",
                    "--poses", "wave:2,1",
                    "--size",  "160x120",
                    "--pmd",   "44x36",
                    "--speed", "0.5,30"};
  ASSERT_EQ(run(words), 0);
  const auto first = dataset::read_stereo_scene(folder_ / "pose_001");
  const auto samples = dataset::read_pmd(folder_ / "pose_001" / "pmd");
  EXPECT_EQ(samples->after_pair_us, 6000);
  EXPECT_NEAR(std::hypot(number(truth()["poses"][1]["velocity_m_s"][0]),
                         number(truth()["poses"][1]["velocity_m_s"][1])),
              0.5, 1e-9);
  ASSERT_EQ(run(words), 0);
  EXPECT_EQ(dataset::read_stereo_scene(folder_ / "pose_001")->left.pixels, first->left.pixels);
  EXPECT_EQ(dataset::read_pmd(folder_ / "pose_001" / "pmd")->frames[0].pixels,
            samples->frames[0].pixels);
  Words other = words;
  other[3] = "wave:2,2";
  ASSERT_EQ(run(other), 0);
  EXPECT_NE(dataset::read_stereo_scene(folder_ / "pose_001")->left.pixels, first->left.pixels);
}

TEST_F(CalibrationSet, OfARawSceneHasWhatAPerfectPairSees) {
  ASSERT_EQ(run({"--scene", "hall", "--misbuilt", "2", "--size", "160x120", "--pmd", "44x36"}), 0);
  const auto raw = dataset::read_stereo_scene(folder_);
  const auto ideal = dataset::read_stereo_scene(folder_ / "ideal");
  ASSERT_TRUE(raw && ideal);
  EXPECT_FALSE(raw->truth || raw->rig);
  ASSERT_TRUE(ideal->truth && ideal->rig && ideal->visible);
  EXPECT_NE(raw->left.pixels, ideal->left.pixels);
  // The published calibration rectifies the raw pictures into what the ideal pair sees.
  board::SceneOptions options;
  options.name = "hall";
  options.size = hal::emu::Size{160, 120};
  options.pmd = hal::emu::Size{44, 36};
  options.rig.misbuilt = board::Misbuilt{.seed = 2};
  const board::SceneWorld world = board::render_world(options);
  const dsp::StereoRig& rig = world.imagery->calibration().stereo;
  ASSERT_TRUE(rig.raw);
  EXPECT_NEAR(rig.left.fx, ideal->rig->left.fx, 1e-9);
  EXPECT_NEAR(rig.doff_px, ideal->rig->doff_px, 1e-9);
  EXPECT_EQ(number(truth()["left"]["k1"]), rig.raw->left.k1);
}

TEST_F(CalibrationSet, PublishesTheDrawingWhereAsked) {
  board::SceneOptions options;
  options.size = hal::emu::Size{64, 48};
  options.pmd = hal::emu::Size{44, 36};
  options.rig.misbuilt = board::Misbuilt{.seed = 2};
  options.rig.publishes_drawing = true;
  const board::SceneWorld world = board::render_world(options);
  const dsp::Calibration& published = world.imagery->calibration();
  EXPECT_FALSE(published.stereo.raw);
  EXPECT_EQ(published.stereo.baseline_m, hal::emu::corridor_rig().stereo.baseline_m);
  EXPECT_EQ(published.pmd_to_stereo.rotation, hal::emu::corridor_rig().pmd_to_stereo.rotation);
  EXPECT_STREQ(dsp::problem(published), "");
}

TEST_F(CalibrationSet, RefusesWhatItCannotDo) {
  for (const Words& words :
       {Words{"--poses", "wave:2,1"}, Words{"--scene", "board:chess,9x6,0"},
        Words{"--scene", "board:print,/nowhere.pgm,1"},
        Words{"--scene", "board:chess,9x6,0.04", "--poses", "dance:3"}, Words{"--rig", "moon"},
        Words{"--misbuilt", "1,40,3"}, Words{"--left-lens", "600,600,320"},
        Words{"--left-lens", "600,600,320,240,-3"}, Words{"--blur", "6"}, Words{"--publish", "x"},
        Words{"--left-lens", "600,600,320,240,-3,0"}, Words{"--right-place", "0,0,0,0,0,0"},
        Words{"--right-place", "0,0,0,-0.1,0,0"}, Words{"--pmd-light", "0"},
        Words{"--speed", "fast"}, Words{"--hold", "0"}}) {
    EXPECT_EQ(run(words), 2) << words.front() << " " << words.back();
  }
  EXPECT_FALSE(std::filesystem::exists(folder_));
}

// Live: held, then moving, round and round; both in one order on every run.
TEST(LiveBoard, IsHeldAndMoves) {
  board::SceneOptions options;
  options.name = "board:chess,5x4,0.06";
  options.size = hal::emu::Size{160, 120};
  options.pmd = hal::emu::Size{44, 36};
  options.board.poses = hal::emu::PoseScript{.count = 2, .seed = 1};
  options.board.hold = 3;
  options.board.moves = 2;
  ASSERT_TRUE(board::seen_rig(options));
  EXPECT_TRUE(board::moves(options));
  const board::SceneWorld world = board::render_world(options);
  const auto same_place = [&](std::uint32_t a, std::uint32_t b) {
    return world.imagery->depth(a).pixels == world.imagery->depth(b).pixels;
  };
  EXPECT_TRUE(same_place(0, 2));
  EXPECT_FALSE(same_place(2, 3));
  EXPECT_FALSE(same_place(3, 4));
  EXPECT_FALSE(same_place(0, 5));
  EXPECT_TRUE(same_place(5, 7));
  EXPECT_TRUE(same_place(0, 10));  // the round is over
  EXPECT_NE(hash(expose(*world.imagery, 0)), hash(expose(*world.imagery, 10)));  // noise
}

}  // namespace
}  // namespace stof::test

#include "hal/emu/imagery/replay.h"

#include <cmath>

#include <gtest/gtest.h>

#include "hal/emu/cameras/pmd_camera.h"
#include "hal/emu/cameras/stereo_camera.h"
#include "hal/emu/devices/clock.h"
#include "tests/dataset/scratch.h"
#include "tests/support/recorded_scenes.h"

namespace stof::test {
namespace {

using hal::emu::Replay;

class ReplayTest : public Scratch {
 protected:
  std::filesystem::path put_scene(const std::string& gt, const std::string& rig = "") const {
    put("scene/left.pgm", "P5\n3 2\n255\nabcdef");
    put("scene/right.pgm", "P5\n3 2\n255\nuvwxyz");
    if (!gt.empty()) {
      put("scene/gt_left.pgm", "P5\n3 2\n255\n" + gt);
    }
    put("scene/meta.txt", "scene scene\nwidth 3\nheight 2\ngt_scale 4\nndisp 16\n" + rig);
    return folder() / "scene";
  }
};

TEST_F(ReplayTest, EveryExposureShowsTheFilesBytes) {
  const auto replay = Replay::open(put_scene(""), std::nullopt);
  ASSERT_TRUE(replay) << replay.error().message;
  EXPECT_EQ((*replay)->stereo_size(), (hal::emu::Size{3, 2}));
  EXPECT_EQ((*replay)->pmd_size(), hal::emu::Size{});
  EXPECT_EQ((*replay)->disparities(), 16);
  for (const std::uint32_t number : {0U, 1U, 77U}) {
    std::string left(6, '\0');
    std::string right(6, '\0');
    (*replay)->left(number, {reinterpret_cast<std::uint8_t*>(left.data()), 3, 2});
    (*replay)->right(number, {reinterpret_cast<std::uint8_t*>(right.data()), 3, 2});
    EXPECT_EQ(left, "abcdef");
    EXPECT_EQ(right, "uvwxyz");
  }
}

TEST_F(ReplayTest, WithoutPmdRecordingTheRigIsAssumedAndUsable) {
  const auto replay = Replay::open(put_scene(""), std::nullopt);
  ASSERT_TRUE(replay);
  EXPECT_TRUE((*replay)->rig_is_assumed());
  EXPECT_STREQ(dsp::problem((*replay)->calibration()), "");
  EXPECT_FALSE((*replay)->depth());
}

TEST_F(ReplayTest, WithoutPmdRecordingTheRigIsThatOfTheScene) {
  const auto replay = Replay::open(put_scene(std::string("\x04\x08\x10\x28\x00\x02", 6),
                                             "f_px 600\nbaseline_m 0.12\ndoff_px 1\n"),
                                   std::nullopt);
  ASSERT_TRUE(replay) << replay.error().message;
  EXPECT_FALSE((*replay)->rig_is_assumed());
  const dsp::StereoRig& rig = (*replay)->calibration().stereo;
  EXPECT_EQ(rig.left.fx, 600);
  EXPECT_EQ(rig.baseline_m, 0.12);
  EXPECT_EQ(rig.doff_px, 1);
  EXPECT_STREQ(dsp::problem((*replay)->calibration()), "");
  EXPECT_FLOAT_EQ((*replay)->depth()->pixels[1], 600 * 0.12F / (2 + 1));
}

TEST_F(ReplayTest, TruthIsDepthByTheCalibration) {
  const auto replay =
      Replay::open(put_scene(std::string("\x04\x08\x10\x28\x00\x02", 6)), std::nullopt);
  ASSERT_TRUE(replay) << replay.error().message;
  const auto depth = (*replay)->depth();
  ASSERT_TRUE(depth);
  const float scale = static_cast<float>(3 * Replay::kAssumedBaseline);  // f = width
  const std::array<float, 4> disparity{1, 2, 4, 10};
  for (std::size_t i = 0; i < disparity.size(); ++i) {
    EXPECT_FLOAT_EQ(depth->pixels[i], scale / disparity[i]);
  }
  EXPECT_TRUE(std::isinf(depth->pixels[4])) << "0 in the file is unknown";
  EXPECT_FLOAT_EQ(depth->pixels[5], scale / 0.5F);
}

TEST_F(ReplayTest, MissingFolderAndRecordingAreRefusedInOneLine) {
  const auto nowhere = Replay::open(folder() / "nowhere", std::nullopt);
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(std::ranges::count(nowhere.error().message, '\n'), 0);
  EXPECT_NE(nowhere.error().message.find("nowhere"), std::string::npos);
  const auto no_pmd = Replay::open(put_scene(""), folder() / "none_64x16");
  ASSERT_FALSE(no_pmd);
  EXPECT_NE(no_pmd.error().message.find("none_64x16"), std::string::npos);
}

class RecordedReplayTest : public test::RecordedScenes {
 protected:
  static std::filesystem::path stereo(const std::string& name) {
    return test::recorded_scenes() / "stereo" / name;
  }
  static std::filesystem::path pmd(const std::string& name) {
    return test::recorded_scenes() / "tof/sim" / name;
  }
};

TEST_F(RecordedReplayTest, CamerasDeliverTheFilesPixels) {
  const auto replay = Replay::open(stereo("Cones"), pmd("scene/Cones_64x16"));
  ASSERT_TRUE(replay) << replay.error().message;
  EXPECT_FALSE((*replay)->rig_is_assumed());
  EXPECT_STREQ(dsp::problem((*replay)->calibration()), "");
  hal::emu::Clock clock;
  hal::emu::StereoCamera camera(clock, **replay, {});
  hal::emu::PmdCamera pmd_camera(clock, **replay, {});
  camera.on_edge(clock.now());
  pmd_camera.on_edge(clock.now());
  const auto frame = camera.wait_frame(clock.now() + std::chrono::seconds(1));
  const auto set = pmd_camera.wait_frame(clock.now() + std::chrono::seconds(1));
  ASSERT_TRUE(frame && set);
  const auto scene = dataset::read_stereo_scene(stereo("Cones"));
  const auto recording = dataset::read_pmd(pmd("scene/Cones_64x16"));
  ASSERT_TRUE(scene && recording);
  for (int y = 0; y < scene->left.height; ++y) {
    EXPECT_TRUE(std::ranges::equal((*frame)->left.row(y), scene->left.view().row(y)));
    EXPECT_TRUE(std::ranges::equal((*frame)->right.row(y), scene->right.view().row(y)));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    for (int y = 0; y < 16; ++y) {
      EXPECT_TRUE(std::ranges::equal((*set)->samples[k].row(y), recording->samples(0)[k].row(y)));
    }
  }
}

TEST_F(RecordedReplayTest, TruthHasThePmdRecordingsScale) {
  const auto replay = Replay::open(stereo("Teddy"), pmd("scene/Teddy_176x144"));
  ASSERT_TRUE(replay) << replay.error().message;
  const auto depth = (*replay)->depth();
  ASSERT_TRUE(depth);
  for (const float z : depth->pixels) {
    ASSERT_TRUE(std::isinf(z) || (z > 0.5F && z < 7.5F)) << z;
  }
}

TEST_F(RecordedReplayTest, RecordingWithoutARigIsRefused) {
  const auto replay = Replay::open(stereo("Cones"), pmd("wall/z1000"));
  ASSERT_FALSE(replay);
  EXPECT_NE(replay.error().message.find("z1000.json: has no rig"), std::string::npos)
      << replay.error().message;
}

}  // namespace
}  // namespace stof::test

#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "board/emu/emu_options.h"
#include "board/emu/scenes.h"
#include "board/emu/write_pair.h"
#include "hal/emu/imagery/moving_scene.h"
#include "hal/emu/scenes/room.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using Words = std::vector<std::string_view>;

board::EmuOptions parsed(const Words& words) {
  const auto options = board::parse_emu_options(words);
  EXPECT_TRUE(options) << (options ? "" : options.error().message);
  return options.value_or(board::EmuOptions{});
}

void expect_refused(const Words& words, const std::string& fact) {
  const auto options = board::parse_emu_options(words);
  ASSERT_FALSE(options) << words.front();
  const std::string& line = options.error().message;
  EXPECT_NE(line.find(fact), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos);
}

TEST(EmuOptions, TakesSceneFlags) {
  const board::EmuOptions options =
      parsed({"--scene", "room:17", "--size", "320x240", "--pmd", "64x16", "--seed", "9", "--turn",
              "pitch:-0.1", "--turn", "yaw:0.2", "--range-offset", "-12.5"});
  EXPECT_EQ(options.scene.name, "room:17");
  EXPECT_EQ(options.scene.size, (hal::emu::Size{320, 240}));
  EXPECT_EQ(options.scene.pmd, (hal::emu::Size{64, 16}));
  EXPECT_EQ(options.scene.seed, 9U);
  EXPECT_EQ(options.scene.misplacement.pitch_degrees, -0.1);
  EXPECT_EQ(options.scene.misplacement.yaw_degrees, 0.2);
  EXPECT_EQ(options.scene.misplacement.roll_degrees, 0);
  EXPECT_EQ(options.scene.misplacement.range_offset_m, -0.0125);
  EXPECT_EQ(parsed({}).scene.name, "corridor");
  EXPECT_EQ(parsed({"--pmd", "none"}).scene.pmd, hal::emu::Size{});
  EXPECT_EQ(parsed({"--no-tof"}).scene.pmd, hal::emu::Size{});
}

TEST(EmuOptions, ARecordingTakesNoSceneAndNoFaults) {
  EXPECT_EQ(parsed({"--replay", "raw.mcap", "--free-run"}).replay, "raw.mcap");
  for (const Words& words :
       {Words{"--replay", "raw.mcap", "--scene", "hall"}, Words{"--replay", "raw.mcap", "--no-tof"},
        Words{"--replay", "raw.mcap", "--dataset", "d"},
        Words{"--replay", "raw.mcap", "--fault", "stereo:drop:3"}}) {
    expect_refused(words, "is in the recording");
  }
  expect_refused({"--replay"}, "takes a value");
}

TEST(EmuOptions, TakesFaultsOfOneOrMoreCalls) {
  const board::EmuOptions options =
      parsed({"--fault", "pmd:vanish:30+300", "--fault", "stereo:freeze:7:10"});
  const hal::emu::FaultPlan& pmd = options.faults_of(board::Device::kPmd);
  for (const std::uint32_t call : {0U, 29U, 330U, 1000U}) {
    EXPECT_EQ(pmd.at(call).kind, hal::emu::FaultKind::kNone) << call;
  }
  EXPECT_EQ(pmd.at(30).kind, hal::emu::FaultKind::kVanish);
  EXPECT_EQ(pmd.at(329).kind, hal::emu::FaultKind::kVanish);
  const hal::emu::FaultPlan& stereo = options.faults_of(board::Device::kStereo);
  EXPECT_EQ(stereo.at(7).kind, hal::emu::FaultKind::kFreeze);
  EXPECT_EQ(stereo.at(8).kind, hal::emu::FaultKind::kNone);
  EXPECT_EQ(stereo.at(17).kind, hal::emu::FaultKind::kFreeze);
}

TEST(EmuOptions, TakesEightFaultsOfADevice) {
  Words words;
  for (int i = 0; i < 7; ++i) {
    words.insert(words.end(), {"--fault", "pmd:drop:5"});
  }
  words.insert(words.end(), {"--fault", "pmd:dark:7+2", "--fault", "stereo:drop:7"});
  const board::EmuOptions options = parsed(words);
  const hal::emu::FaultPlan& pmd = options.faults_of(board::Device::kPmd);
  EXPECT_EQ(pmd.at(5).kind, hal::emu::FaultKind::kDrop);
  EXPECT_EQ(pmd.at(8).kind, hal::emu::FaultKind::kDark);
  words.insert(words.end(), {"--fault", "pmd:drop:50"});
  expect_refused(words, "eight of a device");
}

TEST(EmuOptions, FindsThePmdRecordingBesideTheDataset) {
  namespace fs = std::filesystem;
  const fs::path data = fs::path(testing::TempDir()) / "recording_beside";
  for (const char* const folder : {"stereo/cones", "stereo/alone", "tof/scenes/wall"}) {
    fs::create_directories(data / folder);
  }
  fs::create_directories(data / "tof/sim/scene");
  std::ofstream(data / "tof/sim/scene/cones_64x16.json") << "{}";
  std::ofstream(data / "tof/sim/scene/wall_64x16.json") << "{}";
  EXPECT_EQ(board::recording_beside(data / "stereo/cones"), data / "tof/sim/scene/cones_64x16");
  EXPECT_EQ(board::recording_beside(data / "stereo/cones/"), data / "tof/sim/scene/cones_64x16");
  EXPECT_EQ(board::recording_beside(data / "stereo/../stereo/./cones"),
            data / "tof/sim/scene/cones_64x16");
  EXPECT_EQ(board::recording_beside(data / "tof/scenes/wall"), data / "tof/sim/scene/wall_64x16");
  EXPECT_EQ(board::recording_beside(data / "stereo/alone"), std::nullopt);
  EXPECT_EQ(board::recording_beside("/"), std::nullopt);
  fs::remove_all(data);
}

TEST(EmuOptions, RefusesWhatMeansNothingInOneLine) {
  for (const char* const name : {"moon",
                                 "room:",
                                 "room:x",
                                 "room:-1",
                                 "room:4294967296",
                                 "floor:",
                                 "floor:60",
                                 "floor:60,",
                                 "floor:19,15",
                                 "floor:121,15",
                                 "floor:60,-1",
                                 "floor:60,31",
                                 "floor:60,15,",
                                 "floor:60,15,x",
                                 "floor:60,15,1,1",
                                 "floor:nan,15",
                                 "floors",
                                 "floor60,15",
                                 "drive:",
                                 "drive:hall",
                                 "drive:hall,",
                                 "drive:hall,1.6",
                                 "drive:hall,-1",
                                 "drive:walking,1",
                                 "drive:drive:hall,1,1"}) {
    expect_refused({"--scene", name}, name);
  }
  for (const char* const size : {"640", "x", "640x", "8x640", "640x480x3", "4000x3000", "none"}) {
    expect_refused({"--size", size}, "--size");
  }
  for (const char* const turn : {"pitch", "pitch:", "up:1", "yaw:nan", "roll:11", "yaw:1deg"}) {
    expect_refused({"--turn", turn}, "--turn");
  }
  expect_refused({"--range-offset", "inf"}, "--range-offset");
  expect_refused({"--seed", "-1"}, "--seed");
  for (const char* const flag : {"--scene", "--size", "--pmd", "--seed", "--turn"}) {
    expect_refused({flag}, flag);
  }
  expect_refused({"--turn", "yaw:1", "--dataset", "x"}, "exclude");
  expect_refused({"--scene", "walking", "--truth", "x.pfm"}, "moves");
  expect_refused({"--scene", "drive:hall,1", "--truth", "x.pfm", "--free-run"}, "moves");
  expect_refused({"--scene", "drive:hall,1"}, "--free-run");
}

TEST(RenderWorld, ChangesTheRigAsAsked) {
  board::SceneOptions options;
  options.name = "hall";
  options.size = hal::emu::Size{160, 100};
  options.pmd = hal::emu::Size{64, 48};
  options.misplacement.yaw_degrees = 0.5;
  const board::SceneWorld world = board::render_world(options);
  EXPECT_EQ(world.imagery->stereo_size(), (hal::emu::Size{160, 100}));
  EXPECT_EQ(world.imagery->pmd_size(), (hal::emu::Size{64, 48}));
  EXPECT_EQ(world.imagery->depth(1).width, 160);
  EXPECT_EQ(world.imagery->calibration().pmd.fixed_pattern.size(), std::size_t{64} * 48);
  EXPECT_STREQ(dsp::problem(world.imagery->calibration()), "");
  EXPECT_EQ(world.imagery->calibration().pmd_to_stereo.rotation,
            hal::emu::hall_rig().pmd_to_stereo.rotation);
  options.seed = 77;
  const board::SceneWorld other = board::render_world(options);
  EXPECT_NE(hash(expose(*world.imagery, 1)), hash(expose(*other.imagery, 1)));
  EXPECT_EQ(world.imagery->depth(1).pixels, other.imagery->depth(1).pixels);
}

TEST(RenderWorld, KnowsWhatIsSeenAboveAFloor) {
  for (const auto& [name, height, tilt] :
       {std::tuple("floor", 0.6, 15.0), std::tuple("floor:20,0", 0.2, 0.0),
        std::tuple("floor:120,30,7", 1.2, 30.0), std::tuple("floor:45.5,7.25", 0.455, 7.25)}) {
    board::SceneOptions options;
    ASSERT_EQ(board::take_scene_flag("--scene", name, options), true) << name;
    options.size = hal::emu::Size{160, 120};
    options.pmd = hal::emu::Size{};
    const board::SceneWorld world = board::render_world(options);
    ASSERT_TRUE(world.floor) << name;
    EXPECT_EQ(world.floor->height_m, height);
    EXPECT_EQ(world.floor->tilt_degrees, tilt);
    EXPECT_EQ(world.floor->surface.width, 160);
    // The floor is in the bottom row.
    EXPECT_EQ(world.floor->surface.view().at(80, 119), dataset::Surface::kFloor);
  }
  board::SceneOptions options;
  options.size = hal::emu::Size{64, 48};
  EXPECT_FALSE(board::render_world(options).floor);
}

class Pair : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  int run(const Words& more) {
    Words words{text_};
    words.insert(words.end(), more.begin(), more.end());
    return board::write_pair(words);
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("stof_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  std::string text_ = folder_.string();
};

TEST_F(Pair, IsWhatTheCamerasOfTheSceneExpose) {
  ASSERT_EQ(run({"--scene", "room:5", "--size", "160x120", "--pmd", "44x36", "--frames", "2",
                 "--exposure", "3"}),
            0);
  board::SceneOptions options;
  options.name = "room:5";
  options.size = hal::emu::Size{160, 120};
  options.pmd = hal::emu::Size{44, 36};
  const board::SceneWorld world = board::render_world(options);
  const auto scene = dataset::read_stereo_scene(folder_);
  ASSERT_TRUE(scene) << scene.error().message;
  const Exposed exposed = expose(*world.imagery, 3);
  EXPECT_EQ(scene->left.pixels, exposed.left.pixels);
  EXPECT_EQ(scene->right.pixels, exposed.right.pixels);
  EXPECT_EQ(scene->ndisp, world.imagery->disparities());
  ASSERT_TRUE(scene->truth);
  ASSERT_TRUE(scene->rig);
  EXPECT_EQ(scene->rig->baseline_m, world.imagery->calibration().stereo.baseline_m);
  const double focal = scene->rig->left.fx * scene->rig->baseline_m;
  const dataset::Image<float> depth = world.imagery->depth(3);
  for (std::size_t i = 0; i < depth.pixels.size(); i += 97) {
    EXPECT_NEAR(static_cast<double>(scene->truth->pixels[i]),
                focal / static_cast<double>(depth.pixels[i]), 1.0 / 256);
  }
  const auto recording = dataset::read_pmd(folder_ / "pmd");
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames.size(), 2U);
  EXPECT_TRUE(recording->has_rig);
  EXPECT_EQ(recording->calibration.pmd_to_stereo.rotation,
            world.imagery->calibration().pmd_to_stereo.rotation);
  const std::size_t plane = exposed.samples[0].pixels.size();
  for (std::uint32_t frame = 0; frame < 2; ++frame) {
    const Exposed expected = expose(*world.imagery, 3 + frame);
    for (std::size_t k = 0; k < 4; ++k) {
      const auto begin =
          recording->frames[frame].pixels.begin() + static_cast<std::ptrdiff_t>(k * plane);
      EXPECT_TRUE(std::equal(begin, begin + static_cast<std::ptrdiff_t>(plane),
                             expected.samples[k].pixels.begin()))
          << frame << " " << k;
    }
  }
}

// Each folder is what a run of its own for that exposure writes.
TEST_F(Pair, SequenceIsExposureAfterExposure) {
  const Words drive{"--scene", "drive:corridor,1.5", "--size", "64x48", "--pmd", "44x36"};
  Words words = drive;
  words.insert(words.end(), {"--exposure", "7", "--sequence", "3"});
  ASSERT_EQ(run(words), 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "left.pgm"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "0010"));
  board::SceneOptions options;
  for (std::size_t i = 0; i < drive.size(); i += 2) {
    ASSERT_EQ(board::take_scene_flag(drive[i], drive[i + 1], options), true);
  }
  const board::SceneWorld world = board::render_world(options);
  for (const std::uint32_t number : {8U, 7U}) {
    const std::filesystem::path folder = folder_ / ("000" + std::to_string(number));
    const Exposed expected = expose(*world.imagery, number);
    EXPECT_EQ(dataset::read_stereo_scene(folder)->left.pixels, expected.left.pixels);
    const auto recording = dataset::read_pmd(folder / "pmd");
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_EQ(recording->frames.size(), 1U);
    EXPECT_EQ(recording->frames[0].pixels.front(), expected.samples[0].pixels.front());
  }
}

TEST_F(Pair, AboveAFloorHasItsTruth) {
  ASSERT_EQ(run({"--scene", "floor:40,20", "--size", "160x120", "--pmd", "none"}), 0);
  board::SceneOptions options;
  options.name = "floor:40,20";
  options.size = hal::emu::Size{160, 120};
  const board::SceneWorld world = board::render_world(options);
  const auto scene = dataset::read_stereo_scene(folder_);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_TRUE(scene->floor && world.floor);
  EXPECT_EQ(scene->floor->height_m, 0.4);
  EXPECT_EQ(scene->floor->tilt_degrees, 20);
  EXPECT_EQ(scene->floor->surface.pixels, world.floor->surface.pixels);
}

TEST_F(Pair, WithoutPmdCameraHasNoRecording) {
  ASSERT_EQ(run({"--size", "64x48", "--pmd", "none"}), 0);
  EXPECT_TRUE(dataset::read_stereo_scene(folder_));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "pmd.json"));
}

TEST_F(Pair, RefusesWhatItCannotDo) {
  EXPECT_EQ(board::write_pair({}), 2);
  for (const Words& words :
       {Words{"another"}, Words{"--scene"}, Words{"--scene", "moon"}, Words{"--frames", "0"},
        Words{"--frames", "x"}, Words{"--moon", "1"}, Words{"--scene", "walking", "--frames", "2"},
        Words{"--sequence", "2", "--frames", "2"}}) {
    EXPECT_EQ(run(words), 2) << words.front();
  }
  EXPECT_FALSE(std::filesystem::exists(folder_));
}

}  // namespace
}  // namespace stof::test

#include <cmath>

#include "dataset/dataset.h"
#include "tests/dataset/scratch.h"
#include "tests/support/recorded_scenes.h"

// On the recorded scenes, where they are: the folder named by STOF_DATA.
namespace stof::dataset {
namespace {

using RecordedData = test::RecordedScenes;

TEST_F(RecordedData, EveryStereoSceneLoadsWithTruthInsideItsSearchRange) {
  int scenes = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(test::recorded_scenes() / "stereo")) {
    if (!entry.is_directory()) {
      continue;
    }
    const Loaded<StereoScene> scene = read_stereo_scene(entry.path());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->name, entry.path().filename());
    ASSERT_TRUE(scene->truth && scene->visible) << scene->name;
    for (std::size_t i = 0; i < scene->truth->pixels.size(); ++i) {
      const float disparity = scene->truth->pixels[i];
      ASSERT_TRUE(std::isinf(disparity) ||
                  (disparity > 0 && disparity < static_cast<float>(scene->ndisp)));
      ASSERT_FALSE(std::isinf(disparity) && scene->visible->pixels[i] != 0) << scene->name;
    }
    ++scenes;
  }
  EXPECT_GE(scenes, 4);
}

TEST_F(RecordedData, EveryPmdRecordingLoadsWithTheSizeItSays) {
  int recordings = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(test::recorded_scenes() / "tof" / "sim")) {
    if (entry.path().extension() != ".json") {
      continue;
    }
    std::filesystem::path prefix = entry.path();
    const Loaded<PmdRecording> recording = read_pmd(prefix.replace_extension());
    ASSERT_TRUE(recording) << recording.error().message;
    const dsp::Pinhole& lens = recording->calibration.pmd.lens;
    ASSERT_FALSE(recording->frames.empty());
    for (const Image<std::uint16_t>& frame : recording->frames) {
      EXPECT_EQ(frame.width, lens.width);
      EXPECT_EQ(frame.height, 4 * lens.height);
    }
    ++recordings;
  }
  EXPECT_GE(recordings, 40);
}

// A board with 0.9 of white: the middle of the picture sees 2 A of it, but for odd harmonics (6
// percent) and the angle of the light.
TEST_F(RecordedData, AWhiteSurfaceIsAsBrightAsTheWallSays) {
  const std::filesystem::path wall = test::recorded_scenes() / "tof" / "sim" / "wall";
  for (const auto& [name, metres] :
       {std::pair{"z1500", 1.5}, std::pair{"z2000", 2.0}, std::pair{"z4000", 4.0}}) {
    const Loaded<PmdRecording> recording = read_pmd(wall / name);
    ASSERT_TRUE(recording) << recording.error().message;
    const dsp::PmdSensor& sensor = recording->calibration.pmd;
    EXPECT_EQ(sensor.emitter_count, 2);
    const int u = static_cast<int>(std::lround(sensor.lens.cx));
    const int v = static_cast<int>(std::lround(sensor.lens.cy));
    double i = 0, q = 0;
    for (std::size_t k = 0; k < recording->frames.size(); ++k) {
      const PmdRecording::Samples samples = recording->samples(k);
      i += samples[0].at(u, v) - samples[2].at(u, v);
      q += samples[3].at(u, v) - samples[1].at(u, v);
    }
    const double amp2 = std::hypot(i, q) / static_cast<double>(recording->frames.size());
    const double want = 2 * 0.9 * sensor.white_lsb / (metres * metres);
    EXPECT_NEAR(amp2 / want, 1, 0.1) << name;
  }
}

TEST_F(RecordedData, ScenesAndTheirPmdRecordingsShareARig) {
  for (const char* name : {"Cones", "Teddy", "Tsukuba", "Venus"}) {
    const Loaded<StereoScene> scene = read_stereo_scene(test::recorded_scenes() / "stereo" / name);
    ASSERT_TRUE(scene) << scene.error().message;
    for (const char* size : {"_64x16", "_176x144"}) {
      const Loaded<PmdRecording> recording =
          read_pmd(test::recorded_scenes() / "tof" / "sim" / "scene" / (std::string(name) + size));
      ASSERT_TRUE(recording) << recording.error().message;
      ASSERT_TRUE(recording->has_rig);
      EXPECT_EQ(recording->calibration.stereo.left.cx, (scene->left.width - 1) / 2.0) << name;
      EXPECT_EQ(recording->calibration.stereo.left.cy, (scene->left.height - 1) / 2.0) << name;
      EXPECT_EQ(recording->calibration.pmd.fixed_pattern.size(),
                recording->frames[0].pixels.size() / 4);
    }
  }
}

}  // namespace
}  // namespace stof::dataset

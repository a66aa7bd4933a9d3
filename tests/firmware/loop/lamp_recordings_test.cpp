#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dataset/pmd_recording.h"
#include "firmware/loop/light_guard.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"
#include "tests/support/recorded_scenes.h"

// The lamp's rule on recorded and rendered samples, and on what these cameras would give with a
// dark lamp: the shares that docs/DESIGN.md tells.
namespace stof::firmware {
namespace {

constexpr double kLeastLit = 0.39;  // share of pixels
constexpr double kMostDark = 0.001;

using Planes = std::array<std::vector<std::uint16_t>, 4>;

// One camera: its constants, and frames with the lamp on.
struct Camera {
  std::string name;
  dsp::Calibration calibration;
  std::vector<Planes> frames;
};

std::vector<std::uint16_t> pixels(dsp::ImageView<const std::uint16_t> image) {
  std::vector<std::uint16_t> out;
  for (int y = 0; y < image.height(); ++y) {
    out.insert(out.end(), image.row(y).begin(), image.row(y).end());
  }
  return out;
}

hal::PmdFrame frame_of(const Planes& planes, const dsp::Pinhole& lens) {
  hal::PmdFrame frame;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    frame.samples[k] = {planes[k].data(), lens.width, lens.height};
  }
  return frame;
}

// Two frames of every scene that was recorded in that folder.
std::vector<Camera> recorded(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") {
      files.push_back(entry.path());
    }
  }
  std::ranges::sort(files);
  std::vector<Camera> out;
  for (std::filesystem::path file : files) {
    auto recording = dataset::read_pmd(file.replace_extension());
    EXPECT_TRUE(recording) << file;
    Camera camera{.name = file.filename(), .calibration = recording->calibration, .frames = {}};
    camera.calibration.pmd.fixed_pattern = {};  // the recording's memory
    for (std::size_t i = 0; i < std::min<std::size_t>(2, recording->frames.size()); ++i) {
      Planes planes;
      const auto samples = recording->samples(i);
      for (std::size_t k = 0; k < samples.size(); ++k) {
        planes[k] = pixels(samples[k]);
      }
      camera.frames.push_back(std::move(planes));
    }
    out.push_back(std::move(camera));
  }
  return out;
}

Camera rendered(const std::string& name, const hal::emu::Scene& scene, hal::emu::Rig rig) {
  hal::emu::resize_stereo(rig, 64, 48);
  hal::emu::RenderedScene world(scene, rig);
  const dsp::Pinhole& lens = rig.pmd_lens;
  Camera camera{.name = name, .calibration = world.calibration(), .frames = {}};
  camera.calibration.pmd.fixed_pattern = {};
  Planes planes;
  for (int k = 0; k < 4; ++k) {
    std::vector<std::uint16_t>& plane = planes[static_cast<std::size_t>(k)];
    plane.resize(static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height));
    world.pmd(1, k, {plane.data(), lens.width, lens.height});
  }
  camera.frames.push_back(std::move(planes));
  return camera;
}

std::vector<Camera> rendered_scenes() {
  using namespace hal::emu;
  return {rendered("corridor", corridor(), corridor_rig()), rendered("hall", hall(), hall_rig())};
}

struct Dark {
  double ambient = 1;  // times what the frame has
  double noise = 1;    // times what the calibration says
  double flicker = 0;  // share by which ambient light changes from sample to sample
};

// What these pixels would give without the lamp: all that is not modulated, with its noise.
Planes darkened(const Camera& camera, const Planes& lit, const Dark& dark, std::uint32_t seed) {
  const dsp::PmdSensor& sensor = camera.calibration.pmd;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> change(-dark.flicker, dark.flicker);
  const std::array<double, 4> level{1 + change(random), 1 + change(random), 1 + change(random),
                                    1 + change(random)};
  Planes out;
  for (std::size_t i = 0; i < lit[0].size(); ++i) {
    const double mean = (lit[0][i] + lit[1][i] + lit[2][i] + lit[3][i]) / 4.0;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const double light = dark.ambient * std::max(mean - sensor.dark_lsb, 0.0) * level[k];
      const double variance = sensor.noise_lsb * sensor.noise_lsb +
                              (light + sensor.suppressed_lsb) / sensor.electrons_per_lsb;
      const double value =
          sensor.dark_lsb + light + dark.noise * std::sqrt(variance) * normal(random);
      out[k].push_back(static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, 65535.0))));
    }
  }
  return out;
}

double share(const LightGuard::Count& count) { return 1.0 * count.lit / count.all; }

void expect_lit_and_dark_apart(const std::string& which, const std::vector<Camera>& cameras) {
  double least = 1;
  double most = 0;
  int frames = 0;
  std::uint32_t seed = 0;
  for (const Camera& camera : cameras) {
    const dsp::Pinhole& lens = camera.calibration.pmd.lens;
    LightGuard guard(camera.calibration.pmd);
    for (const Planes& lit : camera.frames) {
      const hal::PmdFrame shown = frame_of(lit, lens);
      EXPECT_TRUE(guard.is_lit(shown)) << camera.name;
      least = std::min(least, share(guard.count(shown)));
    }
    for (const double noise : {1.0, 2.0, 4.0, 8.0}) {
      for (const double ambient : {0.0, 1.0, 3.0}) {
        const Planes dark = darkened(camera, camera.frames[0], {ambient, noise}, ++seed);
        const hal::PmdFrame shown = frame_of(dark, lens);
        EXPECT_FALSE(guard.is_lit(shown))
            << camera.name << " noise " << noise << " ambient " << ambient;
        most = std::max(most, share(guard.count(shown)));
        ++frames;
      }
    }
  }
  std::cout << which << ": of the pixels looked at " << 100 * least
            << " percent or more are lit, and " << 100 * most << " percent at most in " << frames
            << " dark frames\n";
  EXPECT_GE(least, kLeastLit);
  EXPECT_LE(most, kMostDark);
}

class LampRecordings : public test::RecordedScenes {
 protected:
  static std::filesystem::path folder(const char* name) {
    return test::recorded_scenes() / "tof" / name;
  }
};

TEST_F(LampRecordings, OfTheCameraThatTheRuleWasFittedOn) {
  expect_lit_and_dark_apart("camera A", recorded(folder("sim/scene")));
}

TEST_F(LampRecordings, OfACameraThatItWasNotFittedOn) {
  expect_lit_and_dark_apart("camera B", recorded(folder("camera_b/scene")));
}

TEST(LampRendered, OfRenderedScenes) { expect_lit_and_dark_apart("rendered", rendered_scenes()); }

// Ambient light that flickers by a tenth from sample to sample has an amplitude, but not the
// modulation ratio of the lamp's.
void expect_flicker_told_from_light(const std::string& which, const std::vector<Camera>& cameras) {
  int lit = 0;
  int frames = 0;
  for (const Camera& camera : cameras) {
    LightGuard guard(camera.calibration.pmd);
    for (std::uint32_t seed = 1; seed <= 5; ++seed) {
      const Planes dark = darkened(camera, camera.frames[0], {.flicker = 0.1}, seed);
      lit += guard.is_lit(frame_of(dark, camera.calibration.pmd.lens)) ? 1 : 0;
      ++frames;
    }
  }
  std::cout << which << ": " << lit << " of " << frames
            << " dark frames with flicker pass for lit\n";
  EXPECT_EQ(lit, 0);
}

TEST_F(LampRecordings, FlickerIsNoLight) {
  expect_flicker_told_from_light("camera A", recorded(folder("sim/scene")));
  expect_flicker_told_from_light("camera B", recorded(folder("camera_b/scene")));
}

TEST(LampRendered, FlickerIsNoLight) {
  expect_flicker_told_from_light("rendered", rendered_scenes());
}

}  // namespace
}  // namespace stof::firmware

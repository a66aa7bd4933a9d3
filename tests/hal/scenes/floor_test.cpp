#include "hal/emu/scenes/floor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hal/emu/imagery/grey.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/viewpoint.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using namespace hal::emu;

std::vector<FloorView> all_views() {
  std::vector<FloorView> out;
  for (const double height : {kMinFloorHeightM, 0.6, kMaxFloorHeightM}) {
    for (const double tilt : {0.0, 15.0, kMaxFloorTilt}) {
      out.push_back({.height_m = height, .tilt_degrees = tilt});
    }
  }
  return out;
}

std::string name(const FloorView& view) {
  return std::to_string(view.height_m) + " m, " + std::to_string(view.tilt_degrees) + " degrees";
}

dataset::Image<dataset::Surface> surfaces(const FloorScene& floor, const Rig& rig) {
  const dataset::Image<int> objects =
      render_objects({floor.scene, rig.left_camera_pose}, LensRays(rig.stereo.left));
  dataset::Image<dataset::Surface> out(objects.width, objects.height);
  std::ranges::transform(objects.pixels, out.pixels.begin(), [&](int object) {
    return object < 0 ? dataset::Surface::kOther
                      : floor.surfaces.at(static_cast<std::size_t>(object));
  });
  return out;
}

// Z by the camera's height and tilt alone: a level plane `below` the camera, an upright one at `z`.
struct Formula {
  double sine;
  double cosine;
  double y;  // of the ray (x, y, 1)
  double level(double below) const { return below / (y * cosine + sine); }
  double upright(double z) const { return z / (cosine - y * sine); }
};

TEST(Floor, DepthIsThatOfItsPlanesByFormula) {
  for (const FloorView& view : all_views()) {
    const FloorScene floor = floor_scene(view);
    const Rig rig = small(floor.rig);
    const dataset::Image<dataset::Surface> surface = surfaces(floor, rig);
    const RenderedScene rendered(floor.scene, rig);
    const double tilt = view.tilt_degrees * std::numbers::pi / 180;
    const double wall = floor.scene.objects.back().pose.position.z;
    for (int y = 0; y < surface.height; ++y) {
      const Formula formula{.sine = std::sin(tilt),
                            .cosine = std::cos(tilt),
                            .y = (y - rig.stereo.left.cy) / rig.stereo.left.fy};
      for (int x = 0; x < surface.width; ++x) {
        const double depth = static_cast<double>(rendered.depth().view().at(x, y));
        const double tolerance = 1e-6 * depth;  // a float's
        switch (surface.view().at(x, y)) {
          case dataset::Surface::kFloor:
            ASSERT_NEAR(depth, formula.level(view.height_m), tolerance) << name(view);
            break;
          case dataset::Surface::kLowerFloor:
            ASSERT_NEAR(depth, formula.level(view.height_m + 0.1), tolerance) << name(view);
            break;
          case dataset::Surface::kWall:
            ASSERT_NEAR(depth, formula.upright(wall), tolerance) << name(view);
            break;
          case dataset::Surface::kBox:
          case dataset::Surface::kGlass:
            ASSERT_LT(depth, formula.upright(4)) << name(view);
            break;
          case dataset::Surface::kOther:
            FAIL() << name(view) << ": nothing at " << x << " " << y;
        }
      }
    }
  }
}

TEST(Floor, CameraIsWhereItsNameSays) {
  const Rig rig = floor_scene({.height_m = 0.9, .tilt_degrees = 30}).rig;
  const Vec3 ahead = rig.left_camera_pose.turn({0, 0, 1});
  EXPECT_EQ(rig.left_camera_pose.position.y, -0.9);  // y points down
  EXPECT_NEAR(ahead.x, 0, 1e-12);
  EXPECT_NEAR(ahead.y, 0.5, 1e-12);
  EXPECT_NEAR(ahead.z, std::sqrt(0.75), 1e-12);
}

TEST(Floor, ShowsEverySurfaceInEveryView) {
  for (const FloorView& view : all_views()) {
    const FloorScene floor = floor_scene(view);
    const dataset::Image<dataset::Surface> surface = surfaces(floor, small(floor.rig));
    const double pixels = static_cast<double>(surface.pixels.size());
    for (const dataset::Surface each :
         {dataset::Surface::kFloor, dataset::Surface::kLowerFloor, dataset::Surface::kBox,
          dataset::Surface::kGlass, dataset::Surface::kWall}) {
      EXPECT_GT(static_cast<double>(std::ranges::count(surface.pixels, each)), 0.01 * pixels)
          << name(view) << ", surface " << static_cast<int>(each);
    }
  }
}

TEST(Floor, FitsItsSearchRangeAndItsPmdCamera) {
  for (const FloorView& view : all_views()) {
    const FloorScene floor = floor_scene(view);
    EXPECT_LE(floor.rig.disparities, 128) << name(view);
    const Rig rig = small(floor.rig);
    RenderedScene rendered(floor.scene, rig);
    EXPECT_STREQ(dsp::problem(rendered.calibration()), "") << name(view);
    const float nearest = std::ranges::min(rendered.depth().pixels);
    const double focal = rig.stereo.left.fx * rig.stereo.baseline_m;
    EXPECT_LT(focal / static_cast<double>(nearest), rendered.disparities() - 1) << name(view);
    const Exposed exposed = expose(rendered, 1);
    for (const auto& sample : exposed.samples) {
      EXPECT_LT(std::ranges::max(sample.pixels), rendered.calibration().pmd.saturation_lsb)
          << name(view);
    }
  }
}

TEST(Floor, HasATextureOfAFewGreyLevels) {
  constexpr int kWindow = 9;
  for (const FloorView& view : {FloorView{.height_m = kMinFloorHeightM, .tilt_degrees = 30},
                                FloorView{}, FloorView{.height_m = kMaxFloorHeightM}}) {
    const FloorScene floor = floor_scene(view);
    const dataset::Image<dataset::Surface> surface = surfaces(floor, floor.rig);
    const dataset::Image<std::uint16_t> left =
        render_grey(floor.scene, {floor.scene, floor.rig.left_camera_pose},
                    LensRays(floor.rig.stereo.left), floor.rig.grey);
    double sum = 0;
    int windows = 0;
    for (int y = 0; y + kWindow <= left.height; y += kWindow) {
      for (int x = 0; x + kWindow <= left.width; x += kWindow) {
        double total = 0;
        double squares = 0;
        bool floor_alone = true;
        for (int i = 0; i < kWindow * kWindow; ++i) {
          const int u = x + i % kWindow;
          const int v = y + i / kWindow;
          const double level = left.view().at(u, v) / static_cast<double>(1 << kGreyBits);
          total += level;
          squares += level * level;
          floor_alone = floor_alone && surface.view().at(u, v) == dataset::Surface::kFloor;
        }
        if (floor_alone) {
          const double mean = total / (kWindow * kWindow);
          sum += std::sqrt(squares / (kWindow * kWindow) - mean * mean);
          ++windows;
        }
      }
    }
    ASSERT_GT(windows, 50) << name(view);
    EXPECT_GT(sum / windows, 1.2) << name(view);
    EXPECT_LT(sum / windows, 3) << name(view);
  }
}

// What is behind the pane is what the grey cameras see; the PMD camera reads neither of the two.
TEST(Floor, GlassIsSomethingElseForEachSensor) {
  const FloorScene floor = floor_scene({});
  const Rig rig = small(floor.rig);
  const Viewpoint left(floor.scene, rig.left_camera_pose);
  const Viewpoint pmd(floor.scene, rig.left_camera_pose * true_pmd_pose(rig));
  const Sensors sensors(rig);
  const CleanViews views = sensors.render(floor.scene);
  const auto is_glass = [&](const Hit& hit) {
    return hit.object >= 0 &&
           floor.surfaces[static_cast<std::size_t>(hit.object)] == dataset::Surface::kGlass;
  };
  int seen = 0;
  int apart = 0;
  for (int y = 0; y < rig.pmd_lens.height; ++y) {
    for (int x = 0; x < rig.pmd_lens.width; ++x) {
      const Vec3 ray = undistorted_ray(rig.pmd_lens, x, y);
      const Hit pane = pmd.look(ray.x, ray.y);
      if (!is_glass(pane)) {
        continue;
      }
      const Hit behind = pmd.look_past(pane.object, ray.x, ray.y);
      const double nearer = pane.t * length(ray);
      const double farther = behind.t * length(ray);
      if (farther < 1.2 * nearer) {
        continue;  // close to where it stands
      }
      const std::size_t at = static_cast<std::size_t>(y * rig.pmd_lens.width + x);
      const Decoded decoded = decode(sensors.calibration().pmd, clean_samples(views.pmd, x, y), at);
      const double from_pane = range_error(sensors.calibration().pmd, decoded, nearer);
      const double from_behind = range_error(sensors.calibration().pmd, decoded, farther);
      ++seen;
      apart += from_pane > 0.05 * nearer && from_behind < -0.05 * farther ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 30);
  EXPECT_GT(apart, seen * 8 / 10);
  const Hit pane = left.look(-0.24, 0);
  ASSERT_TRUE(is_glass(pane));
  const Hit behind = left.look_past(pane.object, -0.24, 0);
  EXPECT_GT(behind.t, 1.2 * pane.t);
}

TEST(Floor, IsAnotherOneForEachSeedAndTheSameForOne) {
  const auto left = [](std::uint32_t seed) {
    const FloorScene floor = floor_scene({.seed = seed});
    return Sensors(small(floor.rig)).render(floor.scene).left.pixels;
  };
  EXPECT_EQ(left(1), left(1));
  EXPECT_NE(left(1), left(2));
}

TEST(Floor, GivesTheSameBitsOnEveryMachine) {
  const FloorScene floor = floor_scene({});
  RenderedScene rendered(floor.scene, small(floor.rig));
  EXPECT_EQ(hash(expose(rendered, 5)), 10369748887539901463ULL);
}

}  // namespace
}  // namespace stof::test

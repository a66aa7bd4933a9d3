#include "hal/emu/scenes/room.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/viewpoint.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using namespace hal::emu;

constexpr std::uint32_t kRooms = 100;

std::array<Pose, 3> cameras(const Rig& rig) {
  return {rig.left_camera_pose,
          rig.left_camera_pose * Pose{.position = {rig.stereo.baseline_m, 0, 0}},
          rig.left_camera_pose * true_pmd_pose(rig)};
}

// Distance of whatever the camera sees through a field that is a little wider than its own.
std::pair<double, double> nearest_and_farthest(const Scene& scene, const Pose& camera) {
  const Viewpoint viewpoint(scene, camera);
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = 0;
  for (double y = -0.5; y <= 0.5; y += 0.02) {
    for (double x = -0.62; x <= 0.62; x += 0.02) {
      const Hit hit = viewpoint.look(x, y);
      const double range =
          hit.object < 0 ? std::numeric_limits<double>::infinity() : hit.t * length({x, y, 1});
      nearest = std::min(nearest, range);
      farthest = std::max(farthest, range);
    }
  }
  return {nearest, farthest};
}

// A ray that leaves the inside of a solid shape hits nothing of it; from outside, one of these
// around a sphere of directions would. Inside is where the shape's own inequality says so.
bool is_inside(const SceneObject& object, const Vec3& world) {
  const Vec3 p = object.pose.undo(world);
  const Vec3& h = object.half;
  const double x = p.x / h.x;
  const double y = p.y / h.y;
  switch (object.shape) {
    case Shape::kRectangle:
      return false;
    case Shape::kBox:
      return std::abs(x) <= 1 && std::abs(y) <= 1 && std::abs(p.z) <= h.z;
    case Shape::kCylinder:
      return x * x + p.z * p.z / (h.z * h.z) <= 1 && std::abs(y) <= 1;
    case Shape::kEllipsoid:
      return x * x + y * y + p.z * p.z / (h.z * h.z) <= 1;
  }
  return false;
}

TEST(RandomRoom, IsClosedAndNeitherTooNearNorTooFar) {
  for (std::uint32_t seed = 0; seed < kRooms; ++seed) {
    const Room room = random_room(seed);
    for (const Pose& camera : cameras(room.rig)) {
      const auto [nearest, farthest] = nearest_and_farthest(room.scene, camera);
      EXPECT_GT(nearest, 0.8) << "room " << seed;
      EXPECT_LT(farthest, 7.1) << "room " << seed;
      for (const SceneObject& object : room.scene.objects) {
        EXPECT_FALSE(is_inside(object, camera.position)) << "room " << seed;
      }
    }
  }
}

TEST(RandomRoom, IsAnotherOneForEachSeedAndTheSameForOne) {
  const Room a = random_room(3);
  const Room b = random_room(3);
  const Room c = random_room(4);
  ASSERT_EQ(a.scene.objects.size(), b.scene.objects.size());
  EXPECT_EQ(a.rig.stereo.baseline_m, b.rig.stereo.baseline_m);
  EXPECT_EQ(a.scene.objects.back().pose.position.z, b.scene.objects.back().pose.position.z);
  EXPECT_NE(a.rig.stereo.baseline_m, c.rig.stereo.baseline_m);
  EXPECT_NE(a.scene.objects.back().pose.position.z, c.scene.objects.back().pose.position.z);
}

TEST(RandomRoom, HasThingsOfManyKindsInTheEnd) {
  std::array<int, 4> shapes{};
  std::array<int, 4> textures{};
  for (std::uint32_t seed = 0; seed < kRooms; ++seed) {
    for (const SceneObject& object : random_room(seed).scene.objects) {
      ++shapes[static_cast<std::size_t>(object.shape)];
      ++textures[static_cast<std::size_t>(object.material.texture)];
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_GT(shapes[i], 100) << i;
    EXPECT_GT(textures[i], 50) << i;
  }
}

TEST(RandomRoom, FitsItsSearchRangeAndItsPmdCamera) {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    const Room room = random_room(seed);
    const Rig rig = small(room.rig);
    RenderedScene rendered(room.scene, rig);
    EXPECT_STREQ(dsp::problem(rendered.calibration()), "") << seed;
    const float nearest = std::ranges::min(rendered.depth().pixels);
    const double focal = rig.stereo.left.fx * rig.stereo.baseline_m;
    EXPECT_LT(focal / static_cast<double>(nearest), rendered.disparities() - 1) << seed;
    EXPECT_LE(room.rig.disparities, 128) << seed;
    const Exposed exposed = expose(rendered, 1);
    for (const auto& sample : exposed.samples) {
      EXPECT_LT(std::ranges::max(sample.pixels), rendered.calibration().pmd.saturation_lsb) << seed;
    }
  }
}

TEST(RandomRoom, PmdReadingsAreTheTruthOfTheirRays) {
  int usable = 0;
  int near = 0;
  for (std::uint32_t seed = 20; seed < 25; ++seed) {
    const Room room = random_room(seed);
    const Rig rig = small(room.rig);
    const Sensors sensors(rig);
    const CleanViews views = sensors.render(room.scene);
    const dsp::PmdSensor& sensor = sensors.calibration().pmd;
    const Viewpoint viewpoint(room.scene, rig.left_camera_pose * true_pmd_pose(rig));
    for (int y = 0; y < rig.pmd_lens.height; ++y) {
      for (int x = 0; x < rig.pmd_lens.width; ++x) {
        const Vec3 ray = undistorted_ray(rig.pmd_lens, x, y);
        const double truth = viewpoint.look(ray.x, ray.y).t * length(ray);
        const std::size_t at = static_cast<std::size_t>(y * rig.pmd_lens.width + x);
        const Decoded decoded = decode(sensor, clean_samples(views.pmd, x, y), at);
        if (decoded.ratio > sensor.frequency.min_modulation_ratio) {
          ++usable;
          near += std::abs(range_error(sensor, decoded, truth)) < 0.02 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(usable, 6000);
  EXPECT_GT(near, usable * 9 / 10);  // the rest: edges and surfaces seen from the side
}

TEST(RandomRoom, GivesTheSameBitsOnEveryMachine) {
  const Room room = random_room(6);
  RenderedScene rendered(room.scene, small(room.rig));
  EXPECT_EQ(hash(expose(rendered, 2)), 11764968506572560202ULL);
}

}  // namespace
}  // namespace stof::test

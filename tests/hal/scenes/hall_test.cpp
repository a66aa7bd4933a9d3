#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/imagery/sensors.h"
#include "hal/emu/scenes/viewpoint.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using namespace hal::emu;

const double kTurnM = dsp::kLightMetresPerSecond / (2.0 * 20e6);

// A pixel of the PMD camera that sees one surface of one object.
struct Surface {
  int x = 0;
  int y = 0;
  bool textured = false;
  double range_m = 0;
  double cosine = 0;  // of incidence
};

std::vector<Surface> surfaces(const Scene& scene, const Rig& rig) {
  const Viewpoint viewpoint(scene, rig.left_camera_pose * true_pmd_pose(rig));
  const dsp::Pinhole& lens = rig.pmd_lens;
  std::vector<Surface> out;
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      const Vec3 ray = undistorted_ray(lens, x, y);
      const Hit centre = viewpoint.look(ray.x, ray.y);
      bool alone = centre.object >= 0;
      for (const double dx : {-0.6, 0.0, 0.6}) {
        for (const double dy : {-0.6, 0.0, 0.6}) {
          const Vec3 beside = undistorted_ray(lens, x + dx, y + dy);
          const Hit hit = viewpoint.look(beside.x, beside.y);
          alone = alone && hit.object == centre.object && hit.face == centre.face;
        }
      }
      if (alone) {
        const Material& material = scene.objects[static_cast<std::size_t>(centre.object)].material;
        const Vec3 back = viewpoint.pose().turn(-1.0 / length(ray) * ray);
        out.push_back({.x = x,
                       .y = y,
                       .textured = material.contrast > 0,
                       .range_m = centre.t * length(ray),
                       .cosine = dot(centre.normal, back)});
      }
    }
  }
  return out;
}

TEST(Hall, ReachesBeyondTheRangeOfThePmdCameraButNotTwice) {
  const Scene scene = hall();
  const Rig rig = small(hall_rig());
  const RenderedScene rendered(scene, rig);
  const auto [nearest, farthest] = std::ranges::minmax(rendered.depth().pixels);
  EXPECT_GT(nearest, 2.0F);
  EXPECT_GT(farthest, 13.5F);
  EXPECT_LT(farthest, 14.0F);
  const double focal = rig.stereo.left.fx * rig.stereo.baseline_m;
  EXPECT_LT(focal / static_cast<double>(nearest), rendered.disparities() - 1);
  std::array<int, 3> periods{};
  const std::vector<Surface> seen = surfaces(scene, rig);
  for (const Surface& surface : seen) {
    ASSERT_LT(surface.range_m, 2 * kTurnM);
    ++periods[static_cast<std::size_t>(surface.range_m / kTurnM)];
  }
  EXPECT_GT(periods[0], static_cast<int>(seen.size() / 4));
  EXPECT_GT(periods[1], static_cast<int>(seen.size() / 4));
}

TEST(Hall, PeriodsAreSeveralDisparitiesApart) {
  const Rig rig = hall_rig();
  const double focal = rig.stereo.left.fx * rig.stereo.baseline_m;
  for (double z = 7.6; z < 14; z += 0.1) {
    EXPECT_GT(focal / (z - kTurnM) - focal / z, 10) << z;
  }
}

TEST(Hall, ModulationRatioSufficesOnEverythingTextured) {
  const Scene scene = hall();
  const Rig rig = small(hall_rig());
  const Sensors sensors(rig);
  const CleanViews views = sensors.render(scene);
  int far = 0;
  for (const Surface& surface : surfaces(scene, rig)) {
    const Decoded decoded =
        decode(sensors.calibration().pmd, clean_samples(views.pmd, surface.x, surface.y), 0);
    far += surface.textured && surface.range_m > 13 ? 1 : 0;
    if (surface.textured) {
      EXPECT_GT(decoded.ratio, 1.1 * sensors.calibration().pmd.frequency.min_modulation_ratio)
          << surface.x << " " << surface.y << " at " << surface.range_m;
    }
  }
  EXPECT_GT(far, 50);
}

TEST(Hall, PhasesAreTheTruthOfItsRaysInEveryPeriod) {
  const Scene scene = hall();
  const Rig rig = small(hall_rig());
  const Sensors sensors(rig);
  const CleanViews views = sensors.render(scene);
  const dsp::PmdSensor& sensor = sensors.calibration().pmd;
  std::array<int, 2> checked{};
  for (const Surface& surface : surfaces(scene, rig)) {
    const std::size_t at = static_cast<std::size_t>(surface.y * rig.pmd_lens.width + surface.x);
    const Decoded decoded = decode(sensor, clean_samples(views.pmd, surface.x, surface.y), at);
    if (surface.cosine < 0.5) {
      continue;
    }
    // First order in kappa: 4 mm are left of the harmonics. Steps of 1/64 LSB: 2 mm at 10 LSB. What
    // is seen from the side is deep within a pixel, and its texture says which part counts.
    const double slope = std::sqrt(1 - surface.cosine * surface.cosine) / surface.cosine;
    const double tolerance = 0.008 + 0.25 * slope * surface.range_m / rig.pmd_lens.fx;
    EXPECT_NEAR(range_error(sensor, decoded, surface.range_m), 0, tolerance)
        << surface.x << " " << surface.y << " at " << surface.range_m;
    ++checked[surface.range_m > kTurnM ? 1 : 0];
  }
  EXPECT_GT(checked[0], 100);
  EXPECT_GT(checked[1], 100);
}

TEST(Hall, WhiteAtTwoMetresDoesNotSaturate) {
  Rig rig = small(hall_rig());
  rig.left_camera_pose = {};
  RenderedScene rendered(wall(2, {.albedo = 0.85}), rig);
  const Exposed exposed = expose(rendered, 1);
  for (const auto& sample : exposed.samples) {
    EXPECT_LT(std::ranges::max(sample.pixels), rendered.calibration().pmd.saturation_lsb);
  }
}

TEST(Hall, GivesTheSameBitsOnEveryMachine) {
  RenderedScene rendered(hall(), small(hall_rig()));
  EXPECT_EQ(hash(expose(rendered, 5)), 12263840314716667799ULL);
}

}  // namespace
}  // namespace stof::test

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/fusion/fuser.h"
#include "dsp/fusion/unwrap/unwrapper.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/matcher.h"
#include "hal/emu/imagery/noise.h"
#include "hal/emu/imagery/pmd_samples.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"
#include "hal/emu/scenes/viewpoint.h"
#include "tests/support/guarded_part.h"

// Rendered halls of up to 14 m, seen by a PMD camera that repeats after 7.49 m: the whole way from
// pictures and samples to wrap counts.
namespace stof::test {
namespace {

using namespace hal::emu;

constexpr double kTurn = dsp::kLightMetresPerSecond / 40e6;  // metres
constexpr double kDegree = 0.00872664626;                    // half tangent, of small angles

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(dsp::mix(seed) + 0xA11) {}
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_.next() >> 11U) / 9007199254740992.0);
  }
  bool chance(double share) { return between(0, 1) < share; }
  std::uint32_t word() { return static_cast<std::uint32_t>(random_.next() >> 32U); }

 private:
  Xorshift64 random_;
};

// Some are so dark that their amplitude tells nothing, some have one colour, some reflect infrared
// as they please.
Material random_material(Draw& draw, double plain_share, double z) {
  const double albedo = draw.chance(0.15) ? draw.between(0.08, 0.2) : draw.between(0.25, 0.85);
  Material out{.albedo = albedo, .seed = draw.word()};
  if (!draw.chance(plain_share)) {
    out.texture = Texture::kNoise;
    out.contrast = draw.between(0.4, 0.9);
    out.period_m = (z < 6 ? 0.2 : 0.45) * draw.between(0.7, 1.4);
  }
  if (draw.chance(0.5)) {
    out.nir = draw.between(0.2, 0.85);
  }
  return out;
}

void build_shell(Scene& scene, Draw& draw, double half_width, double height, double end) {
  constexpr double kBegin = -1;
  const double middle = (kBegin + end) / 2;
  const double half_length = (end - kBegin) / 2;
  const Pose sideways = turned(kQuarterTurn);
  const Pose level = turned(0, kQuarterTurn);
  add(scene, Shape::kRectangle, {0, 0, middle}, {half_width, half_length, 0},
      random_material(draw, 0.15, 9), level);
  add(scene, Shape::kRectangle, {0, -height, middle}, {half_width, half_length, 0},
      random_material(draw, 0.6, 9), level);
  for (const double side : {-half_width, half_width}) {
    add(scene, Shape::kRectangle, {side, -height / 2, middle}, {half_length, height / 2, 0},
        random_material(draw, 0.15, 9), sideways);
  }
  add(scene, Shape::kRectangle, {0, -height / 2, end}, {half_width, height / 2, 0},
      random_material(draw, 0.1, end));
}

void build_objects(Scene& scene, Draw& draw, double half_width, double height, double end) {
  const int count = 8 + static_cast<int>(draw.between(0, 10));
  for (int i = 0; i < count; ++i) {
    const double z = draw.between(2.4, end - 0.5);
    const double x = std::clamp(draw.between(-0.45, 0.45) * z, -half_width, half_width);
    const double size = draw.between(0.05, 0.1) * z;
    const double wide = size * draw.between(0.5, 1.3);
    const Vec3 half{wide, size * draw.between(0.6, 1.6), size * draw.between(0.4, 1)};
    const double y = draw.chance(0.6) ? -half.y : -draw.between(0.3, height - 0.3);
    constexpr std::array<Shape, 4> kShapes{Shape::kBox, Shape::kCylinder, Shape::kEllipsoid,
                                           Shape::kRectangle};
    const Shape shape = kShapes[static_cast<std::size_t>(draw.between(0, 3.99))];
    const Material material = random_material(draw, 0.25, z);
    add(scene, shape, {x, y, z}, half, material, turned(draw.between(-0.3, 0.3)));
  }
}

Scene random_hall(Draw& draw) {
  Scene scene;
  const double half_width = draw.between(2.5, 5);
  const double height = draw.between(3, 5.5);
  const double end = draw.between(9, 13.9);
  scene.ambient = 0.4;
  build_shell(scene, draw, half_width, height, end);
  build_objects(scene, draw, half_width, height, end);
  for (const double z : {0.5, 4.0, 7.5, 11.0}) {
    scene.lights.push_back({.position = {0, -height + 0.3, z}, .power = 2.2});
  }
  return scene;
}

enum class Kind { kAbove, kCoarse, kBelow };

// hall_rig() with other lenses, places and lights.
Rig random_rig(Draw& draw, Kind kind) {
  Rig rig = hall_rig();
  rig.stereo.baseline_m = draw.between(0.12, 0.28);
  const double focal = draw.between(560, 650);
  rig.stereo.left.fx = focal;
  rig.stereo.left.fy = focal;
  rig.disparities = static_cast<int>(std::ceil(focal * rig.stereo.baseline_m / 1.9 / 16)) * 16;
  if (kind == Kind::kCoarse) {
    rig.pmd_lens = {
        .width = 64, .height = 16, .fx = 45.28, .fy = 45.28, .cx = 32.8, .cy = 10, .k1 = -0.06};
  } else {
    const double pmd_focal = draw.between(158, 218);  // 58 to 44 degrees
    rig.pmd_lens.fx = pmd_focal;
    rig.pmd_lens.fy = pmd_focal;
  }
  const double beside = draw.between(-0.1, 0.1);
  rig.pmd_to_stereo.translation_m = {rig.stereo.baseline_m / 2 + beside, -draw.between(0.03, 0.08),
                                     0.01};
  double pitch = draw.between(-2, 2);
  if (kind == Kind::kBelow) {  // the chapter's place
    rig.pmd_to_stereo.translation_m = {0, 0.3, 0.2};
    pitch = -4;
  }
  const double yaw = draw.between(-2, 2);
  rig.pmd_to_stereo.rotation = turned(yaw * kDegree, pitch * kDegree).rotation;
  rig.pmd.signal_e *= draw.between(0.2, 1);
  rig.seed = draw.word();
  return rig;
}

// What a PMD pixel sees: along the ray of its centre, and the extremes of its middle and sides.
// Metres.
struct Truth {
  double centre;
  double nearest;
  double farthest;
  bool matchable;  // textured, no edge, and where the left camera sees it, stereo works
};

class TruthOfPmd {
 public:
  TruthOfPmd(const Scene& scene, const Rig& rig, dsp::ImageView<const dsp::Disparity> disparity)
      : scene_(scene),
        rig_(rig),
        disparity_(disparity),
        pmd_(scene, rig.left_camera_pose * true_pmd_pose(rig)),
        left_(scene, rig.left_camera_pose) {}

  Truth at(int x, int y) const {
    const Vec3 ray = undistorted_ray(rig_.pmd_lens, x, y);
    const Hit hit = pmd_.look(ray.x, ray.y);
    const double metres = hit.t * length(ray);
    double nearest = metres;
    double farthest = metres;
    for (const double step : {-0.5, 0.5}) {
      for (const Vec3& side : {undistorted_ray(rig_.pmd_lens, x + step, y),
                               undistorted_ray(rig_.pmd_lens, x, y + step)}) {
        const double other = pmd_.look(side.x, side.y).t * length(side);
        nearest = std::min(nearest, other);
        farthest = std::max(farthest, other);
      }
    }
    const Material& material = scene_.objects[static_cast<std::size_t>(hit.object)].material;
    const bool textured = material.texture == Texture::kNoise;
    return {metres, nearest, farthest,
            textured && farthest - nearest < 0.3 * metres && matched(hit.point)};
  }

 private:
  // Within a pixel.
  bool matched(const Vec3& point) const {
    const dsp::Pinhole& lens = rig_.stereo.left;
    const Vec3 p = rig_.left_camera_pose.undo(point);
    const double u = std::floor(lens.fx * p.x / p.z + lens.cx + 0.5);
    const double v = std::floor(lens.fy * p.y / p.z + lens.cy + 0.5);
    if (!(u >= 0 && u < lens.width && v >= 0 && v < lens.height) ||
        left_.look(p.x / p.z, p.y / p.z).t < 0.98 * p.z) {
      return false;
    }
    const dsp::Disparity found = disparity_.at(static_cast<int>(u), static_cast<int>(v));
    const double expected = lens.fx * rig_.stereo.baseline_m / p.z;
    return found.valid() && std::abs(static_cast<double>(found.pixels()) - expected) <= 1;
  }

  const Scene& scene_;
  const Rig& rig_;
  dsp::ImageView<const dsp::Disparity> disparity_;
  Viewpoint pmd_;
  Viewpoint left_;
};

struct Count {
  long valid = 0;
  long wrong = 0;      // valid, half a turn or more off all that the pixel sees
  long strict = 0;     // valid, half a turn or more off what its centre sees
  long wrapped = 0;    // matchable, beyond a turn
  long recovered = 0;  // of them, valid and right
  void operator+=(const Count& more) {
    valid += more.valid;
    wrong += more.wrong;
    strict += more.strict;
    wrapped += more.wrapped;
    recovered += more.recovered;
  }
};

void count(const TruthOfPmd& truth, const dsp::PmdMaps& maps, Count& out) {
  for (int y = 0; y < maps.distance.height(); ++y) {
    for (int x = 0; x < maps.distance.width(); ++x) {
      const double metres = maps.distance.at(x, y) / static_cast<double>(dsp::kQuarterMmPerMetre);
      const bool valid = maps.distance.at(x, y) != dsp::kNoDepth;
      const bool flagged = (maps.flags.at(x, y) & dsp::kPmdWrapped) != 0;
      if (!valid && !flagged) {
        continue;  // nothing was measured
      }
      const Truth here = truth.at(x, y);
      const bool right = valid && std::abs(metres - here.centre) < kTurn / 2;
      const bool possible = metres > here.nearest - kTurn / 2 && metres < here.farthest + kTurn / 2;
      out.valid += valid ? 1 : 0;
      out.wrong += valid && !possible ? 1 : 0;
      out.strict += valid && !right ? 1 : 0;
      if (here.matchable && here.centre > kTurn) {
        ++out.wrapped;
        out.recovered += right ? 1 : 0;
      }
    }
  }
}

Count run(const Scene& scene, const Rig& rig, std::string_view preset) {
  RenderedScene rendered(scene, rig);
  const dsp::Calibration& calibration = rendered.calibration();
  const Size size = rendered.stereo_size();
  const Size pmd = rendered.pmd_size();
  dsp::MatchParams match = dsp::find_preset(preset)->params;
  match.disparities = rendered.disparities();
  const dsp::FusionParams fusion{.max_range = 64000};
  test::GuardedPart<dsp::Matcher> matcher(
      [&](dsp::Arena& own) { return dsp::Matcher(match, size.width, size.height, own); });
  test::GuardedPart<dsp::PmdConverter> converter(
      [&](dsp::Arena& own) { return dsp::PmdConverter(calibration.pmd, own); });
  test::GuardedPart<dsp::Unwrapper> unwrapper([&](dsp::Arena& own) {
    return dsp::Unwrapper(calibration, fusion, 0, match.disparities, size.width, size.height, own);
  });
  dataset::Image<std::uint8_t> left{size.width, size.height};
  dataset::Image<std::uint8_t> right{size.width, size.height};
  dataset::Image<dsp::Disparity> disparity{size.width, size.height};
  std::array<dataset::Image<std::uint16_t>, 4> planes;
  dsp::PmdExposure exposure;
  rendered.left(1, left.view());
  rendered.right(1, right.view());
  for (int k = 0; k < 4; ++k) {
    dataset::Image<std::uint16_t>& plane = planes[static_cast<std::size_t>(k)];
    plane = {pmd.width, pmd.height};
    rendered.pmd(1, k, plane.view());
    exposure.samples[static_cast<std::size_t>(k)] = plane.view();
  }
  matcher->match({.left = left.view(), .right = right.view()}, disparity.view());
  const dsp::PmdMaps& maps = converter->measure({.first = {&exposure, 1}});
  unwrapper->resolve(maps, disparity.view());
  Count out;
  count(TruthOfPmd(scene, rig, disparity.view()), maps, out);
  return out;
}

// At edges a centre tells less than the rest of its pixel: twice as many may differ from it.
void expect(const Count& all, const std::string& what) {
  EXPECT_GT(all.wrapped, 1000) << what;
  EXPECT_LE(10000 * all.wrong, all.valid) << what << ": " << all.wrong << " of " << all.valid;
  EXPECT_LE(5000 * all.strict, all.valid) << what << ": " << all.strict << " of " << all.valid;
  EXPECT_GE(10 * all.recovered, 9 * all.wrapped)
      << what << ": " << all.recovered << " of " << all.wrapped;
}

void run_halls(Kind kind, std::string_view preset, int first, int halls) {
  Count all;
  for (int seed = first; seed < first + halls; ++seed) {
    Draw draw(static_cast<std::uint64_t>(seed));
    const Scene scene = random_hall(draw);
    all += run(scene, random_rig(draw, kind), preset);
  }
  expect(all, std::string(preset));
}

TEST(UnwrapScenes, TheHall) {
  for (const char* preset : {"fast", "quality"}) {
    expect(run(hall(), hall_rig(), preset), preset);
  }
}

TEST(UnwrapScenes, RandomHallsFromAbove) { run_halls(Kind::kAbove, "fast", 100, 6); }
TEST(UnwrapScenes, RandomHallsInTheQualityPreset) { run_halls(Kind::kAbove, "quality", 200, 4); }
TEST(UnwrapScenes, RandomHallsFromBelow) { run_halls(Kind::kBelow, "fast", 300, 4); }
TEST(UnwrapScenes, RandomHallsThroughCoarsePixels) { run_halls(Kind::kCoarse, "fast", 400, 6); }

}  // namespace
}  // namespace stof::test

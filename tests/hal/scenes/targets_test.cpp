#include "hal/emu/scenes/targets.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "hal/emu/imagery/grey.h"
#include "hal/emu/scenes/viewpoint.h"

namespace stof::test {
namespace {

using namespace hal::emu;

dataset::Image<int> objects_of(const Scene& scene, const Rig& rig) {
  return render_objects({scene, rig.left_camera_pose}, LensRays(rig.stereo.left));
}

TEST(Targets, BarsAreAsWideAsTheirNameSays) {
  Rig rig = target_rig();
  resize_stereo(rig, 320, 240);
  for (const double width : {3.0, 8.0, 24.0}) {
    for (const bool level : {false, true}) {
      const dataset::Image<int> objects =
          objects_of(bars_scene({.width_px = width, .level = level}, rig.stereo.left), rig);
      constexpr int kWall = 0;
      const auto pixels = static_cast<double>(
          std::ranges::count_if(objects.pixels, [](int object) { return object > kWall; }));
      const double length = level ? objects.width : objects.height;
      EXPECT_NEAR(pixels, 4 * width * length, 4 * length) << width << (level ? " level" : "");
    }
  }
}

TEST(Targets, StripesRepeatAfterTheirPeriodInPixels) {
  const Rig rig = target_rig();
  const Scene scene = stripes_scene({.period_px = 16, .contrast = 0.5}, rig.stereo.left);
  const Viewpoint viewpoint(scene, rig.left_camera_pose);
  const Material& material = scene.objects.front().material;
  int bright = 0;
  for (int x = -200; x < 200; ++x) {
    const double ray = (x + 0.25) / rig.stereo.left.fx;
    const double here = visible_albedo(material, viewpoint.look(ray, 0).local);
    const double later =
        visible_albedo(material, viewpoint.look(ray + 16 / rig.stereo.left.fx, 0).local);
    EXPECT_EQ(here, later) << x;
    bright += here == material.albedo ? 1 : 0;
  }
  EXPECT_EQ(bright, 200);
}

TEST(Targets, NamesOutOfRangeAreNone) {
  EXPECT_EQ(parse_bars("bars:8,level")->width_px, 8);
  EXPECT_TRUE(parse_bars("bars:8,level")->level);
  EXPECT_FALSE(parse_bars("bars:0.5,upright")->level);
  for (const char* name : {"bars:8", "bars:8,", "bars:0,level", "bars:101,level", "bars:8,oblique",
                           "bars:nan,level", "bars:8,level,1", "bar:8,level"}) {
    EXPECT_FALSE(parse_bars(name)) << name;
  }
  EXPECT_EQ(parse_stripes("stripes:12")->contrast, Stripes{}.contrast);
  EXPECT_EQ(parse_stripes("stripes:12,25")->contrast, 0.25);
  for (const char* name : {"stripes:", "stripes:1", "stripes:201", "stripes:8,", "stripes:8,101",
                           "stripes:8,-1", "stripes:,5"}) {
    EXPECT_FALSE(parse_stripes(name)) << name;
  }
}

}  // namespace
}  // namespace stof::test

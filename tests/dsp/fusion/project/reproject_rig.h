#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>

#include "dsp/fusion/project/reproject.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"

// A rig, a PMD frame and a left view for the tests of the reprojection.
namespace stof::dsp {

inline constexpr double kTurn = 0.10452846326765347;  // sine of 6 degrees

// The chapter's head: a 64 x 16 sensor 30 cm below and 20 cm before the stereo head, looking up.
inline Calibration chapter_rig(int left_width, int left_height) {
  Calibration rig;
  rig.stereo.left = {.width = left_width,
                     .height = left_height,
                     .fx = 1105.9,
                     .fy = 1105.9,
                     .cx = left_width / 2.0,
                     .cy = left_height / 2.0};
  rig.stereo.baseline_m = 0.2;
  rig.pmd.lens = {
      .width = 64, .height = 16, .fx = 45.279, .fy = 45.279, .cx = 32.8, .cy = 10.0, .k1 = -0.1};
  const double c = std::sqrt(1 - kTurn * kTurn);
  rig.pmd_to_stereo = {{1, 0, 0, 0, c, -kTurn, 0, kTurn, c}, {0, 0.3, 0.2}};
  return rig;
}

// Maps with what the reprojection reads.
struct Frame {
  Frame(int width, int height)
      : distance(width, height, width + 2),
        low(width, height, width + 1),
        high(width, height, width),
        flags(width, height, width) {}
  PmdMaps maps() {
    PmdMaps maps;
    maps.distance = distance.view();
    maps.low = low.view();
    maps.high = high.view();
    maps.flags = flags.view();
    return maps;
  }
  void put(int x, int y, int lo, int d, int hi, std::uint8_t flag = 0) {
    distance.view().at(x, y) = static_cast<QuarterMm>(d);
    low.view().at(x, y) = static_cast<QuarterMm>(lo);
    high.view().at(x, y) = static_cast<QuarterMm>(hi);
    flags.view().at(x, y) = flag;
  }
  test::GuardedImage<QuarterMm> distance, low, high;
  test::GuardedImage<std::uint8_t> flags;
};

struct View {
  View(int width, int height, int stride)
      : nearest(width, height, stride, 9),
        low(width, height, stride, 9),
        high(width, height, stride, 9),
        flags(width, height, stride, 9) {}
  SplattedView view() { return {nearest.view(), low.view(), high.view(), flags.view()}; }
  bool padding_untouched() {
    return nearest.padding_is(9) && low.padding_is(9) && high.padding_is(9) && flags.padding_is(9);
  }
  test::GuardedImage<QuarterMm> nearest, low, high;
  test::GuardedImage<std::uint8_t> flags;
};

class Rig {
 public:
  Rig(const Calibration& rig, int left_width, int left_height)
      : owned_([&](Arena& arena) { return Reprojector(rig, left_width, left_height, arena); }) {}

 private:
  test::GuardedPart<Reprojector> owned_;

 public:
  Reprojector& reprojector = *owned_;
};

}  // namespace stof::dsp

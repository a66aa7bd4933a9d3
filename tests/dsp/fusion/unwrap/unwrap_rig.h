#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <new>
#include <vector>

#include "dsp/fusion/unwrap/unwrapper.h"
#include "dsp/pmd/interval/fill_intervals.h"
#include "tests/support/guarded_part.h"

// A PMD camera in the left camera's place, and what both see of surfaces given by a function.
namespace stof::dsp {

inline constexpr int kTurn = 29979;  // 20 MHz, quarter mm

// f b = 80 px m: 26.7 px at 3 m, 7.6 px at 10.5 m. A PMD pixel covers 8 x 8.
inline Calibration unwrap_calibration(int pmd_width, int pmd_height) {
  Calibration rig;
  rig.stereo.left = {.width = 8 * pmd_width,
                     .height = 8 * pmd_height,
                     .fx = 320,
                     .fy = 320,
                     .cx = 8 * pmd_width / 2.0 - 0.5,
                     .cy = 8 * pmd_height / 2.0 - 0.5};
  rig.stereo.baseline_m = 0.25;
  rig.pmd.lens = {.width = pmd_width,
                  .height = pmd_height,
                  .fx = 40,
                  .fy = 40,
                  .cx = pmd_width / 2.0 - 0.5,
                  .cy = pmd_height / 2.0 - 0.5};
  return rig;
}

// Maps as PmdConverter::measure() leaves them.
struct UnwrapMaps {
  UnwrapMaps(int w, int h)
      : distance(elements(w + 2, h)),
        sigma(elements(w + 2, h)),
        amp2(elements(w, h)),
        low(elements(w, h)),
        high(elements(w, h)),
        flags(elements(w, h)) {
    maps.distance = {distance.data() + 1, w, h, w + 2};
    maps.sigma = {sigma.data() + 1, w, h, w + 2};
    maps.amp2 = {amp2.data(), w, h};
    maps.low = {low.data(), w, h};
    maps.high = {high.data(), w, h};
    maps.flags = {flags.data(), w, h};
    maps.range = kTurn;
    maps.widest = kTurn / 2;
  }
  UnwrapMaps(const UnwrapMaps&) = delete;
  UnwrapMaps& operator=(const UnwrapMaps&) = delete;
  ~UnwrapMaps() = default;
  static std::size_t elements(int w, int h) {
    return static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  }
  std::vector<QuarterMm> distance, sigma;
  std::vector<std::uint16_t> amp2;
  std::vector<QuarterMm> low, high;
  std::vector<std::uint8_t> flags;
  PmdMaps maps;
};

// One frame of a rig: surfaces, then resolve().
class UnwrapRig {
 public:
  explicit UnwrapRig(const Calibration& rig, QuarterMm max_range = 64000)
      : calibration(rig),
        width(rig.pmd.lens.width),
        height(rig.pmd.lens.height),
        left_width(rig.stereo.left.width),
        left_height(rig.stereo.left.height),
        pmd(width, height),
        disparities(UnwrapMaps::elements(left_width, left_height)),
        unwrapper_([&](Arena& arena) {
          return Unwrapper(rig, {.max_range = max_range}, 0, kCandidates, left_width, left_height,
                           arena);
        }) {}

  // Metres from the camera's centre of what column x, row y of the PMD camera sees; a place between
  // pixels of the PMD camera is one of the left camera's.
  using Surface = std::function<double(double x, double y)>;

  // Readings that wrap, all with this amplitude (of 2 A).
  void measure(const Surface& surface, int amp2, int sigma = 40) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto whole = static_cast<int>(std::lround(surface(x, y) * kQuarterMmPerMetre));
        const bool there = whole > 0;
        pmd.maps.distance.at(x, y) = static_cast<QuarterMm>(there ? 1 + (whole - 1) % kTurn : 0);
        pmd.maps.sigma.at(x, y) = static_cast<QuarterMm>(there ? sigma : 0);
        pmd.maps.amp2.at(x, y) = static_cast<std::uint16_t>(amp2);
        pmd.maps.flags.at(x, y) = there ? 0 : kPmdLowRatio;
      }
    }
  }
  // Disparities of what lies there; 0 m: none.
  void match(const Surface& surface) {
    const Pinhole& left = calibration.stereo.left;
    for (int y = 0; y < left_height; ++y) {
      for (int x = 0; x < left_width; ++x) {
        const double radial = surface((x + 0.5) / 8 - 0.5, (y + 0.5) / 8 - 0.5);
        const double across = (x - left.cx) / left.fx;
        const double along = (y - left.cy) / left.fy;
        const double z = radial / std::sqrt(1 + across * across + along * along);
        const double raw = 16 * left.fx * calibration.stereo.baseline_m / z;
        disparity().at(x, y) = radial > 0
                                   ? Disparity::from_raw(static_cast<std::int16_t>(raw + 0.5))
                                   : Disparity::none();
      }
    }
  }
  void resolve() { unwrapper_->resolve(pmd.maps, disparity()); }
  void resolve_without_stereo() { unwrapper_->resolve(pmd.maps, {}); }

  ImageView<Disparity> disparity() { return {disparities.data(), left_width, left_height}; }
  int at(int x, int y) const { return pmd.maps.distance.at(x, y); }
  bool flagged(int x, int y) const {
    return (pmd.maps.flags.at(x, y) & kPmdWrapped) != 0 && at(x, y) == 0 &&
           pmd.maps.sigma.at(x, y) == 0 && pmd.maps.low.at(x, y) == 0 &&
           pmd.maps.high.at(x, y) == 0;
  }
  // Pixels with the distance of the surface; of all.
  double share_right(const Surface& surface) const {
    int right = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        right += std::abs(at(x, y) - surface(x, y) * kQuarterMmPerMetre) <= 2 ? 1 : 0;
      }
    }
    return right / static_cast<double>(width * height);
  }
  double share_flagged() const {
    int count = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        count += flagged(x, y) ? 1 : 0;
      }
    }
    return count / static_cast<double>(width * height);
  }

 private:
  static constexpr int kCandidates = 64;

 public:
  Calibration calibration;
  int width;
  int height;
  int left_width;
  int left_height;
  UnwrapMaps pmd;
  std::vector<Disparity> disparities;

 private:
  test::GuardedPart<Unwrapper> unwrapper_;
};

}  // namespace stof::dsp

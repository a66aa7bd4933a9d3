#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "dsp/fusion/resolve/match_evidence.h"

namespace stof::dsp::test {

// f b = 60 px m. The PMD camera sees the same picture, four pixels in one, from the same place.
inline constexpr int kWidth = 64;
inline constexpr int kHeight = 48;
inline constexpr int kFour = 4;
inline constexpr std::uint32_t kRange = 29979;

inline Calibration rig(double focal = 150) {
  Calibration calibration;
  calibration.stereo = {
      .left = {.width = kWidth, .height = kHeight, .fx = 600, .fy = 600, .cx = 31.5, .cy = 23.5},
      .baseline_m = 0.1};
  calibration.pmd.lens = {.width = kWidth / kFour,
                          .height = kHeight / kFour,
                          .fx = focal,
                          .fy = focal,
                          .cx = 7.5,
                          .cy = 5.5};
  return calibration;
}

// A wall matched at 20 px, 3 m away, and a PMD picture without any reading. The left picture is
// grey.
class EvidenceScene {
 public:
  explicit EvidenceScene(double focal = 150)
      : evidence(rig(focal), 0),
        disparity_(kWidth * kHeight, Disparity::from_pixels(20)),
        picture_(kWidth * kHeight, 100),
        images_(4, std::vector<QuarterMm>(kWidth * kHeight / kFour / kFour)),
        flags_(kWidth * kHeight / kFour / kFour) {
    maps.low = image(0);
    maps.high = image(1);
    maps.folded = image(2);
    maps.folded_sigma = image(3);
    maps.flags = {flags_.data(), kWidth / kFour, kHeight / kFour};
    maps.range = kRange;
    evidence.look_at(&maps);
  }

  ImageView<Disparity> view() { return {disparity_.data(), kWidth, kHeight}; }
  ImageView<std::uint8_t> picture() { return {picture_.data(), kWidth, kHeight}; }
  // Columns x and further to the right are brighter.
  void brighten(int x, int by) {
    for (int y = 0; y < kHeight; ++y) {
      for (std::uint8_t& grey : picture().row(y).subspan(static_cast<std::size_t>(x))) {
        grey = static_cast<std::uint8_t>(grey + by);
      }
    }
  }
  void unmatched() { std::ranges::fill(disparity_, Disparity::none()); }
  void read(QuarterMm folded, QuarterMm sigma) {
    std::ranges::fill(images_[2], folded);
    std::ranges::fill(images_[3], sigma);
  }
  void see(QuarterMm low, QuarterMm high) {
    std::ranges::fill(images_[0], low);
    std::ranges::fill(images_[1], high);
  }
  MatchEvidence::Result judge(std::uint8_t ratio = 200, int x = 32, int y = 24,
                              DepthInterval interval = {11800, 12200}) {
    return evidence.judge({.x = x,
                           .y = y,
                           .disparity = Disparity::from_pixels(20),
                           .ratio = ratio,
                           .interval = interval},
                          {view(), picture()});
  }

  MatchEvidence evidence;
  PmdMaps maps;

 private:
  ImageView<QuarterMm> image(std::size_t k) {
    return {images_[k].data(), kWidth / kFour, kHeight / kFour};
  }
  std::vector<Disparity> disparity_;
  std::vector<std::uint8_t> picture_;
  std::vector<std::vector<QuarterMm>> images_;
  std::vector<std::uint8_t> flags_;
};

}  // namespace stof::dsp::test

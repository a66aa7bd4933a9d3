#include "host/picture/disparity_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stof::host {
namespace {

// The part of scale_colour() that disparities use.
constexpr double kWarmest = 0.05;
constexpr double kColdest = 0.92;

constexpr std::array<Rgb, 2> kNone{{{14, 15, 18}, {44, 46, 52}}};
constexpr int kCheckerPx = 3;
constexpr float kWrongAbovePx = 1;  // as in disparity_score.h

}  // namespace

Rgb DisparityScale::colour(double disparity_px) const {
  const double place = std::clamp((near_px - disparity_px) / (near_px - far_px), 0.0, 1.0);
  return scale_colour(std::lerp(kWarmest, kColdest, place));
}

std::vector<double> DisparityScale::ticks() const { return round_ticks(far_px, near_px, 5); }

Rgb none_colour(int x, int y) {
  return kNone[static_cast<std::size_t>((x / kCheckerPx + y / kCheckerPx) % 2)];
}

dataset::Image<Rgb> disparity_picture(const dataset::Image<float>& disparity,
                                      const DisparityScale& scale) {
  dataset::Image<Rgb> picture(disparity.width, disparity.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float d = disparity.view().at(x, y);
      picture.view().at(x, y) = std::isfinite(d) ? scale.colour(d) : none_colour(x, y);
    }
  }
  return picture;
}

dataset::Image<Rgb> metric_picture(const dataset::Image<float>& depth_m, const ColourScale& scale) {
  dataset::Image<Rgb> picture(depth_m.width, depth_m.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float z = depth_m.view().at(x, y);
      picture.view().at(x, y) = std::isfinite(z) && z > 0
                                    ? scale_colour(std::lerp(kWarmest, kColdest, scale.position(z)))
                                    : none_colour(x, y);
    }
  }
  return picture;
}

Rgb finding_colour(Finding finding) {
  switch (finding) {
    case Finding::kUnknown:
      return {150, 152, 158};
    case Finding::kRight:
      return {236, 237, 240};
    case Finding::kTooNear:
      return {214, 48, 49};
    case Finding::kTooFar:
      return {33, 103, 214};
    case Finding::kMissing:
      return kNone[0];
    case Finding::kRightlyRemoved:
      return {20, 146, 84};
    case Finding::kWronglyRemoved:
      return {232, 140, 0};
    case Finding::kFilled:
      return {126, 87, 194};
  }
  return {};
}

dataset::Image<Rgb> finding_picture(const dataset::Image<Finding>& findings,
                                    const dataset::Image<std::uint8_t>& left,
                                    const std::optional<dataset::Image<std::uint8_t>>& pale) {
  constexpr double kOverUnknown = 0.85;
  constexpr double kPale = 0.45;
  dataset::Image<Rgb> picture = as_colour(left, true);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const Finding finding = findings.view().at(x, y);
      Rgb& pixel = picture.view().at(x, y);
      if (finding == Finding::kMissing) {
        pixel = none_colour(x, y);
      } else if (finding == Finding::kUnknown) {
        pixel = mixed(pixel, finding_colour(finding), kOverUnknown);
      } else if (finding != Finding::kRight) {
        const bool is_pale = pale && pale->view().at(x, y) != 0;
        pixel = mixed(pixel, finding_colour(finding), is_pale ? kPale : 1.0);
      }
    }
  }
  return picture;
}

dataset::Image<Finding> differences(const dataset::Image<float>& disparity,
                                    const dataset::Image<float>& truth) {
  dataset::Image<Finding> findings(disparity.width, disparity.height);
  for (std::size_t i = 0; i < findings.pixels.size(); ++i) {
    const float d = disparity.pixels[i];
    const float t = truth.pixels[i];
    if (!std::isfinite(t)) {
      findings.pixels[i] = Finding::kUnknown;
    } else if (!std::isfinite(d)) {
      findings.pixels[i] = Finding::kMissing;
    } else if (std::abs(d - t) <= kWrongAbovePx) {
      findings.pixels[i] = Finding::kRight;
    } else {
      findings.pixels[i] = d > t ? Finding::kTooNear : Finding::kTooFar;
    }
  }
  return findings;
}

dataset::Image<Rgb> as_colour(const dataset::Image<std::uint8_t>& grey, bool washed_out) {
  constexpr double kTowardsWhite = 0.62;
  dataset::Image<Rgb> picture(grey.width, grey.height);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
    const std::uint8_t value = grey.pixels[i];
    const Rgb pixel{value, value, value};
    picture.pixels[i] = washed_out ? mixed(pixel, {255, 255, 255}, kTowardsWhite) : pixel;
  }
  return picture;
}

void draw_frame(dataset::Image<Rgb>& picture, int x0, int y0, int x1, int y1, int thickness,
                Rgb colour) {
  for (int y = std::max(y0 - thickness, 0); y <= std::min(y1 + thickness, picture.height - 1);
       ++y) {
    for (int x = std::max(x0 - thickness, 0); x <= std::min(x1 + thickness, picture.width - 1);
         ++x) {
      if (x < x0 || x > x1 || y < y0 || y > y1) {
        picture.view().at(x, y) = colour;
      }
    }
  }
}

}  // namespace stof::host

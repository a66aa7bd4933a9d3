#include "tests/campaign/wall.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/base/check.h"

namespace stof::campaign {
namespace {

std::uint8_t texture(int x, int y, std::size_t seed) noexcept {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^
                    static_cast<std::uint32_t>(y) * 0x85EBCA77U ^
                    static_cast<std::uint32_t>(seed) * 0xC2B2AE3DU;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12;
  return static_cast<std::uint8_t>(h >> 24);
}

}  // namespace

firmware::Setup setup_of(const RigSize& size) {
  firmware::Setup setup;
  setup.calibration.stereo = {.left = {.width = size.width,
                                       .height = size.height,
                                       .fx = size.focal,
                                       .fy = size.focal,
                                       .cx = (size.width - 1) / 2.0,
                                       .cy = (size.height - 1) / 2.0},
                              .baseline_m = size.baseline_m};
  const double scale = size.focal * size.pmd_width / size.width;
  setup.calibration.pmd.lens = {.width = size.pmd_width,
                                .height = size.pmd_height,
                                .fx = scale,
                                .fy = scale * 0.5,
                                .cx = (size.pmd_width - 1) / 2.0,
                                .cy = (size.pmd_height - 1) / 2.0};
  setup.depth.match = {.disparities = size.disparities,
                       .block_width = 5,
                       .block_height = 5,
                       .left_right_tolerance = 1,
                       .subpixel = dsp::Subpixel::kEquiangular,
                       .confidence = true};
  // So narrow that no two of the distances could be taken for one.
  setup.depth.fusion.trust.sigma_by_ratio.fill(4);
  return setup;
}

void EdgeLog::on_edge(hal::Time edge) noexcept {
  STOF_CHECK(edges_.size() < edges_.capacity());
  edges_.push_back(edge);
}

std::size_t EdgeLog::find(hal::Time edge) const noexcept {
  const auto found = std::ranges::lower_bound(edges_, edge);
  return found != edges_.end() && *found == edge ? static_cast<std::size_t>(found - edges_.begin())
                                                 : edges_.size();
}

void paint_view(dsp::ImageView<std::uint8_t> out, std::size_t edge, int shift) noexcept {
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      out.at(x, y) = texture(x + shift, y, edge);
    }
  }
}

void paint_sample(dsp::ImageView<std::uint16_t> out, double depth_m, int k,
                  const dsp::Pinhole& lens) noexcept {
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const double u = (x - lens.cx) / lens.fx;
      const double v = (y - lens.cy) / lens.fy;
      const double radial = depth_m * std::sqrt(u * u + v * v + 1);
      const double phase = radial * 4 * std::numbers::pi * 20e6 / dsp::kLightMetresPerSecond;
      out.at(x, y) = static_cast<std::uint16_t>(
          std::lround(1500 + 1000 * std::cos(phase + k * std::numbers::pi / 2)));
    }
  }
}

void paint_dark(dsp::ImageView<std::uint16_t> out, std::size_t seed) noexcept {
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      out.at(x, y) = static_cast<std::uint16_t>(500 + texture(x, y, seed) % 4);
    }
  }
}

}  // namespace stof::campaign

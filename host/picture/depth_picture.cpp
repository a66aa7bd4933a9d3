#include "host/picture/depth_picture.h"

#include <array>

#include "host/picture/legend.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::array<Rgb, 2> kChecker{{{38, 40, 44}, {52, 54, 58}}};
constexpr int kNoDepthCheckerPx = 8;

Rgb checker(int x, int y) {
  return kChecker[static_cast<std::size_t>((x / kNoDepthCheckerPx + y / kNoDepthCheckerPx) % 2)];
}

}  // namespace

dataset::Image<Rgb> depth_picture(const dataset::Image<dsp::QuarterMm>& depth,
                                  const ColourScale& scale) {
  dataset::Image<Rgb> map(depth.width, depth.height);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const dsp::QuarterMm z = depth.view().at(x, y);
      const double metres = static_cast<double>(z) / dsp::kQuarterMmPerMetre;
      map.view().at(x, y) = z == dsp::kNoDepth ? checker(x, y) : scale.colour(metres);
    }
  }
  Legend legend{.colour = scale_colour, .ticks = {}, .none = checker};
  for (const double distance : scale.ticks()) {
    legend.ticks.emplace_back(scale.position(distance), printed("%g m", distance));
  }
  return with_legend(map, legend);
}

}  // namespace stof::host

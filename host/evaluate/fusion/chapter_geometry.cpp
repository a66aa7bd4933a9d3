#include "host/evaluate/fusion/chapter_geometry.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/project/reproject.h"
#include "host/evaluate/workspace.h"

namespace stof::host {
namespace {

// For each column (or row) of the left view the nearest one of the PMD's picture, -1 beside it.
std::vector<int> nearest_places(int size, double centre, double focal, int pmd_size,
                                double pmd_centre, double pmd_focal) {
  std::vector<int> places;
  for (int x = 0; x < size; ++x) {
    const double place = std::round((x - centre) * pmd_focal / focal + pmd_centre);
    places.push_back(place >= 0 && place < pmd_size ? static_cast<int>(place) : -1);
  }
  return places;
}

// The interval that a pixel of a depth map stands for; 0, 0 = none.
struct Bounds {
  std::vector<dsp::QuarterMm> low;
  std::vector<dsp::QuarterMm> high;
};

void read_bounds(const dsp::DepthMap& map, int y, Bounds& bounds) {
  for (int x = 0; x < map.depth.width(); ++x) {
    const std::size_t i = static_cast<std::size_t>(x);
    const int half = map.width.at(x, y) / 2;
    bounds.low[i] = static_cast<dsp::QuarterMm>(std::max(map.depth.at(x, y) - half, 0));
    bounds.high[i] = static_cast<dsp::QuarterMm>(map.depth.at(x, y) + half);
  }
}

}  // namespace

void splat_by_scaling(const dsp::PmdMaps& maps, const dsp::Calibration& calibration,
                      const dsp::SplattedView& view) {
  const dsp::Pinhole& left = calibration.stereo.left;
  const dsp::Pinhole& pmd = calibration.pmd.lens;
  const std::vector<int> columns =
      nearest_places(view.low.width(), left.cx, left.fx, pmd.width, pmd.cx, pmd.fx);
  const std::vector<int> rows =
      nearest_places(view.low.height(), left.cy, left.fy, pmd.height, pmd.cy, pmd.fy);
  for (int y = 0; y < view.low.height(); ++y) {
    for (int x = 0; x < view.low.width(); ++x) {
      const int px = columns[static_cast<std::size_t>(x)];
      const int py = rows[static_cast<std::size_t>(y)];
      const bool seen = px >= 0 && py >= 0 && maps.high.at(px, py) > 0;
      view.nearest.at(x, y) = seen ? maps.distance.at(px, py) : dsp::kNoSplat;
      view.low.at(x, y) = seen ? maps.low.at(px, py) : dsp::kNoSplat;
      view.high.at(x, y) = seen ? maps.high.at(px, py) : dsp::kNoDepth;
      view.flags.at(x, y) = seen ? maps.flags.at(px, py) : std::uint8_t{0};
    }
  }
}

void splat_by_geometry(const dsp::PmdMaps& maps, const dsp::Calibration& calibration,
                       const dsp::SplattedView& view) {
  const int width = view.low.width();
  const int height = view.low.height();
  Workspace space(dsp::bytes_taken(
      [&](dsp::Arena& arena) noexcept { dsp::Reprojector(calibration, width, height, arena); }));
  dsp::Arena arena = space.arena();
  dsp::Reprojector reprojector(calibration, width, height, arena);
  reprojector.locate(maps);
  reprojector.splat(view.low.rows(), view);
}

void fuse_by_interval(const dsp::DepthMap& stereo, dsp::ImageView<const std::uint8_t> ratio,
                      const dsp::SplattedView& splatted, dsp::QuarterMm max_range,
                      const dsp::DepthMap& out) {
  const std::size_t width = static_cast<std::size_t>(out.depth.width());
  Bounds bounds{.low = std::vector<dsp::QuarterMm>(width),
                .high = std::vector<dsp::QuarterMm>(width)};
  const std::vector<std::uint8_t> sure(width);
  for (int y = 0; y < out.depth.height(); ++y) {
    if (!ratio.empty()) {
      read_bounds(stereo, y, bounds);
    }
    dsp::best::intersect({bounds.low, bounds.high}, {splatted.low.row(y), splatted.high.row(y)},
                         {ratio.empty() ? std::span(sure) : ratio.row(y), splatted.flags.row(y)},
                         max_range,
                         {out.depth.row(y), out.width.row(y), out.source.row(y), out.cause.row(y)});
  }
}

}  // namespace stof::host

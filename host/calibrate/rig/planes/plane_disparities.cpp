#include "host/calibrate/rig/planes/plane_disparities.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "dataset/files/file.h"
#include "dsp/base/parse_number.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/evaluate/stereo/match.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kFewestDistances = 3;
constexpr std::size_t kMaxMetaBytes = 1U << 20;
constexpr int kCell = 24;               // px
constexpr double kFullShare = 0.5;      // of a cell's pixels that have a match
constexpr float kLargestSpread = 1.5F;  // px from the cell's median
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

lab::MatchParams params_of(const PlaneOptions& options) {
  lab::MatchParams params = lab::method_defaults(lab::Method::kWinnerTakesAll);
  params.cost = lab::Cost::kSsd;
  params.prefilter_cap = std::nullopt;
  params.block_width = options.block;
  params.block_height = options.block;
  params.min_disparity = options.min_disparity;
  params.disparities = options.disparities;
  params.left_right_tolerance = 1;
  params.subpixel = options.subpixel ? dsp::Subpixel::kLeastSquares : dsp::Subpixel::kWhole;
  return params;
}

dataset::Image<float> in_the_middle(const dataset::Image<dsp::Disparity>& found, double middle) {
  dataset::Image<float> map(found.width, found.height, kNone);
  const int left = static_cast<int>(found.width * (1 - middle) / 2);
  const int top = static_cast<int>(found.height * (1 - middle) / 2);
  for (int y = top; y < found.height - top; ++y) {
    for (int x = left; x < found.width - left; ++x) {
      const dsp::Disparity d = found.view().at(x, y);
      if (d.valid()) {
        map.view().at(x, y) = d.pixels();
      }
    }
  }
  return map;
}

std::optional<PlaneCell> cell_at(const dataset::Image<float>& disparity, int left, int top) {
  std::vector<float> found;
  for (int y = top; y < top + kCell; ++y) {
    for (int x = left; x < left + kCell; ++x) {
      const float d = disparity.view().at(x, y);
      if (std::isfinite(d)) {
        found.push_back(d);
      }
    }
  }
  if (static_cast<double>(found.size()) < kFullShare * kCell * kCell) {
    return std::nullopt;
  }
  const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
  std::ranges::nth_element(found, middle);
  const float median = *middle;
  PlaneCell cell;
  double count = 0;
  for (int y = top; y < top + kCell; ++y) {
    for (int x = left; x < left + kCell; ++x) {
      const float d = disparity.view().at(x, y);
      if (std::abs(d - median) <= kLargestSpread) {
        cell.left += x;
        cell.right += x - static_cast<double>(d);
        cell.row += y;
        count += 1;
      }
    }
  }
  if (count < kFullShare * kCell * kCell) {
    return std::nullopt;
  }
  return PlaneCell{cell.left / count, cell.right / count, cell.row / count};
}

}  // namespace

dataset::Loaded<double> plane_distance(const std::filesystem::path& dir) {
  const std::filesystem::path file = dir / "meta.txt";
  const dataset::Loaded<std::string> text = dataset::read_whole(file, kMaxMetaBytes);
  if (!text) {
    return std::unexpected(text.error());
  }
  dataset::HeaderCursor words(*text, 0);
  for (std::string_view word = words.word(); !word.empty(); word = words.word()) {
    if (word == "plane_z_m") {
      const double z = dsp::parse_number<double>(words.word()).value_or(0);
      if (!(z > 0.05) || !(z < 100)) {
        return dataset::refuse(file, "has a plane_z_m that is no distance of 0.05 to 100 m",
                               "give metres");
      }
      return z;
    }
  }
  return dataset::refuse(file, "does not say how far the wall is",
                         "add a line such as plane_z_m 1.6");
}

std::expected<void, dataset::Problem> write_plane_distance(const std::filesystem::path& dir,
                                                           double z_m) {
  return dataset::write_whole(dir / "meta.txt", printed("plane_z_m %.9g\n", z_m));
}

dataset::Loaded<Plane> read_plane(const std::filesystem::path& dir, const PlaneOptions& options) {
  const dataset::Loaded<double> z = plane_distance(dir);
  if (!z) {
    return std::unexpected(z.error());
  }
  dataset::Loaded<Pair> pair = read_pair(dir);
  if (!pair) {
    return std::unexpected(std::move(pair.error()));
  }
  dataset::StereoScene scene;
  scene.name = pair->name;
  scene.left = std::move(pair->left);
  scene.right = std::move(pair->right);
  scene.ndisp = options.disparities;
  const dataset::Loaded<MatchResult> matched =
      match_scene(scene, params_of(options), 1, options.threads);
  if (!matched) {
    return std::unexpected(matched.error());
  }
  Plane plane{.name = scene.name,
              .z_m = *z,
              .disparity = in_the_middle(matched->disparity, options.middle),
              .cells = {}};
  plane.cells = cells_of(plane.disparity);
  const auto found = static_cast<double>(
      std::ranges::count_if(plane.disparity.pixels, [](float d) { return std::isfinite(d); }));
  plane.matched = found / (static_cast<double>(plane.disparity.pixels.size()) * options.middle *
                           options.middle);
  if (plane.cells.empty()) {
    return dataset::refuse(dir, "has hardly any match on the wall",
                           "use a wall with more texture, or a wider --min-disparity and "
                           "--disparities");
  }
  return plane;
}

std::vector<PlaneCell> cells_of(const dataset::Image<float>& disparity) {
  std::vector<PlaneCell> cells;
  for (int top = 0; top + kCell <= disparity.height; top += kCell) {
    for (int left = 0; left + kCell <= disparity.width; left += kCell) {
      if (const std::optional<PlaneCell> cell = cell_at(disparity, left, top)) {
        cells.push_back(*cell);
      }
    }
  }
  return cells;
}

dataset::Loaded<std::vector<Plane>> read_planes(const std::filesystem::path& dir,
                                                const PlaneOptions& options) {
  const dataset::Loaded<std::vector<std::filesystem::path>> pairs = list_pairs(dir);
  if (!pairs) {
    return std::unexpected(pairs.error());
  }
  std::vector<Plane> planes;
  std::set<double> distances;
  for (const std::filesystem::path& pair : *pairs) {
    dataset::Loaded<Plane> plane = read_plane(pair, options);
    if (!plane) {
      return std::unexpected(std::move(plane.error()));
    }
    if (!planes.empty() && (planes.front().disparity.width != plane->disparity.width ||
                            planes.front().disparity.height != plane->disparity.height)) {
      return dataset::refuse(pair, "has pictures of another size than those before it",
                             "give walls of one pair of cameras");
    }
    distances.insert(plane->z_m);
    planes.push_back(std::move(*plane));
  }
  if (distances.size() < kFewestDistances) {
    return dataset::refuse(dir, "has walls at fewer than three distances",
                           "add some, from the nearest to the farthest that is to be measured");
  }
  std::ranges::sort(planes, {}, &Plane::z_m);
  return planes;
}

}  // namespace stof::host

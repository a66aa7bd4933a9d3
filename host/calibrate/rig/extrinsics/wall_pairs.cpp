#include "host/calibrate/rig/extrinsics/wall_pairs.h"

#include <cmath>

#include "dataset/files/file.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/calib/stereo/column_tables.h"
#include "host/calibrate/rig/extrinsics/long_exposure.h"
#include "host/calibrate/rig/extrinsics/subpixel_lock.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/evaluate/fusion/owning_depth_maker.h"
#include "host/evaluate/owning_converter.h"

namespace stof::host {
namespace {

constexpr int kStep = 12;         // px between looks of the pair
constexpr double kPairSigma = 1;  // px; what matters is that all are alike
constexpr double kPmdFloorM = 0.001;

lab::MatchParams params_of(const WallPairOptions& options) {
  dsp::MatchParams params = dsp::for_depth(*dsp::find_preset("quality"));
  params.min_disparity = options.min_disparity;
  params.disparities = options.disparities;
  return lab::as_the_appliance(params);
}

// 1 / Z and its sigma for kPairSigma, by the rig's own columns.
std::vector<PlaneLook> looks_of_pair(const dsp::StereoRig& rig,
                                     dsp::ImageView<const dsp::Disparity> disparity) {
  std::vector<PlaneLook> looks;
  for (int y = kStep / 2; y < disparity.height(); y += kStep) {
    for (int x = kStep / 2; x < disparity.width(); x += kStep) {
      const dsp::Disparity d = disparity.at(x, y);
      if (!d.valid()) {
        continue;
      }
      const double px = static_cast<double>(d.pixels());
      const double q = 1 / dsp::depth_of(rig, x, px);
      const double next = 1 / dsp::depth_of(rig, x, px + kPairSigma);
      if (std::isfinite(q) && q > 0 && std::isfinite(next) && next > q) {
        looks.push_back({.ray = {-dsp::left_tangent(rig, x), (y - rig.left.cy) / rig.left.fy, 1},
                         .q = q,
                         .sigma = next - q,
                         .disparity_px = px});
      }
    }
  }
  return looks;
}

struct PixelSums {
  double distance = 0;
  double variance = 0;
  double count = 0;
};

std::vector<PlaneLook> looks_of_pmd(const LongExposures& seen) {
  const dataset::PmdRecording& recording = seen.recording;
  OwningConverter converter(seen.sensor);
  const dsp::Pinhole& lens = seen.sensor.lens;
  std::vector<PixelSums> sums(dsp::pixel_count(lens.width, lens.height));
  for (std::size_t n = 0; n < recording.frames.size(); ++n) {
    const dsp::PmdMaps& maps = converter->convert(recording.samples(n));
    std::size_t p = 0;
    for (int y = 0; y < lens.height; ++y) {
      for (int x = 0; x < lens.width; ++x, ++p) {
        if (maps.distance.at(x, y) != dsp::kNoDepth && (maps.flags.at(x, y) & dsp::kPmdEdge) == 0) {
          const double sigma = static_cast<double>(maps.sigma.at(x, y)) / dsp::kQuarterMmPerMetre;
          sums[p].distance += static_cast<double>(maps.distance.at(x, y)) / dsp::kQuarterMmPerMetre;
          sums[p].variance += sigma * sigma;
          sums[p].count += 1;
        }
      }
    }
  }
  std::vector<PlaneLook> looks;
  const auto width = static_cast<std::size_t>(lens.width);
  for (std::size_t p = 0; p < sums.size(); ++p) {
    const std::size_t row = p / width;
    const std::array<double, 3> ray =
        dsp::unit_ray(lens, static_cast<double>(p - row * width), static_cast<double>(row));
    const PixelSums& pixel = sums[p];
    if (2 * pixel.count < static_cast<double>(recording.frames.size()) || pixel.count == 0 ||
        ray[2] <= 0) {
      continue;
    }
    const double d = pixel.distance / pixel.count;
    const double sigma = std::max(std::sqrt(pixel.variance) / pixel.count, kPmdFloorM);
    looks.push_back({.ray = {ray[0], ray[1], ray[2]}, .q = 1 / d, .sigma = sigma / (d * d)});
  }
  return looks;
}

std::string tilt_text(const char* who) {
  return std::string(who) + " sees no wall that fills more than half of its picture";
}

}  // namespace

dataset::Loaded<std::vector<BothLooks>> read_looks(const std::filesystem::path& dir,
                                                   const dsp::Calibration& calibration,
                                                   const WallPairOptions& options) {
  const dataset::Loaded<std::vector<std::filesystem::path>> pairs = list_pairs(dir);
  if (!pairs) {
    return std::unexpected(pairs.error());
  }
  dsp::Calibration stereo = calibration;
  stereo.pmd = {};
  const dsp::Pinhole& left = calibration.stereo.left;
  dataset::Loaded<std::unique_ptr<OwningDepthMaker>> maker =
      OwningDepthMaker::make(dir.string(), stereo, left.width, left.height, params_of(options),
                             {.threads = options.threads});
  if (!maker) {
    return std::unexpected(std::move(maker.error()));
  }
  std::vector<BothLooks> looks;
  for (const std::filesystem::path& folder : *pairs) {
    const dataset::Loaded<Pair> pair = read_pair(folder);
    if (!pair) {
      return std::unexpected(pair.error());
    }
    if (pair->left.width != left.width || pair->left.height != left.height) {
      return dataset::refuse(folder,
                             "is " + dataset::size_text(pair->left.width, pair->left.height) +
                                 ", the calibration is of " +
                                 dataset::size_text(left.width, left.height),
                             "give the calibration of this rig");
    }
    dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd(folder / "pmd");
    if (!recording) {
      return std::unexpected(recording.error());
    }
    const dsp::Pinhole& lens = recording->calibration.pmd.lens;
    if (lens.width != calibration.pmd.lens.width || lens.height != calibration.pmd.lens.height) {
      return dataset::refuse(folder / "pmd.json",
                             "is " + dataset::size_text(lens.width, lens.height) +
                                 ", the calibration's PMD camera is another",
                             "give the calibration of this rig");
    }
    (**maker)->match(pair->left.view(), pair->right.view());
    looks.push_back(
        {.name = pair->name,
         .stereo = looks_of_pair((*maker)->calibration().stereo, (**maker)->stereo().disparity),
         .pmd = looks_of_pmd(lengthened(std::move(*recording), calibration.pmd))});
  }
  return looks;
}

FoundWalls walls_of(const std::vector<BothLooks>& looks) {
  SubpixelLock lock;
  for (const BothLooks& both : looks) {
    if (const std::optional<SeenPlane> plane = plane_of(both.stereo, false)) {
      lock.add(both.stereo, *plane);
    }
  }
  FoundWalls found;
  for (const BothLooks& both : looks) {
    const std::optional<SeenPlane> stereo = plane_of(lock.undone(both.stereo), false);
    const std::optional<SeenPlane> pmd = plane_of(both.pmd, true);
    if (stereo && pmd) {
      found.walls.push_back({both.name, *stereo, *pmd});
    } else {
      found.refused.push_back(both.name + ": " + tilt_text(stereo ? "the PMD camera" : "the pair"));
    }
  }
  return found;
}

}  // namespace stof::host

#include "host/calibrate/wall_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/calibrate/fit/pmd_model.h"
#include "host/evaluate/owning_converter.h"

namespace stof::host {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();
constexpr double kRatioOne = 256;  // PmdMaps::ratio

// Of one pixel, over the frames in which it carries a distance.
struct Series {
  double count = 0;
  double sum = 0;
  double squares = 0;
  double sigma_squares = 0;

  void add(double distance_m, double sigma_m) {
    count += 1;
    sum += distance_m;
    squares += distance_m * distance_m;
    sigma_squares += sigma_m * sigma_m;
  }
  double variance_sum() const { return std::max(squares - sum * sum / count, 0.0); }
};

// FrameSums over the frames of one recording.
struct FrameSums {
  explicit FrameSums(std::size_t pixels) : distances(pixels), modulation(pixels) {}
  std::vector<Series> distances;
  std::vector<double> modulation;
  double readings = 0, amp2 = 0, ratio = 0;  // of the middle
  std::array<double, kPmdFlags> flagged{};
  int frames = 0;

  void add(const dsp::PmdMaps& maps, const Middle& middle) {
    ++frames;
    for (int y = 0; y < maps.flags.height(); ++y) {
      for (int x = 0; x < maps.flags.width(); ++x) {
        const std::size_t p = static_cast<std::size_t>(y * maps.flags.width() + x);
        modulation[p] += maps.ratio.at(x, y) / kRatioOne;
        if (maps.distance.at(x, y) != dsp::kNoDepth) {
          distances[p].add(static_cast<double>(maps.distance.at(x, y)) / dsp::kQuarterMmPerMetre,
                           static_cast<double>(maps.sigma.at(x, y)) / dsp::kQuarterMmPerMetre);
        }
        if (middle.holds(x, y)) {
          add_middle(maps, x, y);
        }
      }
    }
  }

 private:
  void add_middle(const dsp::PmdMaps& maps, int x, int y) {
    readings += 1;
    amp2 += maps.amp2.at(x, y);
    ratio += maps.ratio.at(x, y) / kRatioOne;
    for (std::size_t bit = 0; bit < kPmdFlags; ++bit) {
      flagged[bit] += (unsigned{maps.flags.at(x, y)} >> bit & 1U) != 0 ? 1 : 0;
    }
  }
};

void put_maps(const FrameSums& sums, const std::vector<std::array<double, 3>>& rays,
              WallView& view) {
  for (std::size_t p = 0; p < rays.size(); ++p) {
    const Series& pixel = sums.distances[p];
    view.modulation.pixels[p] = static_cast<float>(sums.modulation[p] / sums.frames);
    view.valid_share.pixels[p] = static_cast<float>(pixel.count / sums.frames);
    if (pixel.count > 0) {
      view.z_m.pixels[p] = static_cast<float>(pixel.sum / pixel.count * rays[p][2]);
    }
  }
}

void put_middle(const FrameSums& sums, const std::vector<std::array<double, 3>>& rays,
                const dsp::Pinhole& lens, double z_m, const WallTurn& turn, WallView& view) {
  const Middle middle = middle_of(lens);
  double count = 0, error = 0, freedom = 0, variance = 0, predicted = 0;
  for (std::size_t p = 0; p < rays.size(); ++p) {
    const Series& pixel = sums.distances[p];
    if (pixel.count == 0 ||
        !middle.holds(static_cast<int>(p) % lens.width, static_cast<int>(p) / lens.width)) {
      continue;
    }
    count += pixel.count;
    const std::array<double, 3>& ray = rays[p];
    error += (pixel.sum - pixel.count * distance_to_wall(turn, ray, z_m)) * ray[2];
    if (pixel.count > 1) {
      freedom += pixel.count - 1;
      variance += pixel.variance_sum();
      predicted += (pixel.count - 1) * pixel.sigma_squares / pixel.count;
    }
  }
  if (count > 0) {
    view.error_m = error / count;
  }
  if (freedom > 0) {
    view.spread_m = std::sqrt(variance / freedom);
    view.predicted_m = std::sqrt(predicted / freedom);
  }
  if (sums.readings > 0) {
    view.valid = count / sums.readings;
    view.ratio = sums.ratio / sums.readings;
    view.amp2 = sums.amp2 / sums.readings;
    std::ranges::transform(sums.flagged, view.flagged.begin(),
                           [&sums](double flagged) { return flagged / sums.readings; });
  }
}

}  // namespace

WallView view_wall(const dsp::PmdSensor& sensor, const WallRecording& wall, Frames frames,
                   const WallTurn& turn) {
  const dsp::Pinhole& lens = sensor.lens;
  dsp::PmdSensor used = sensor;
  used.frequency.stray_i_lsb *= wall.exposure;
  used.frequency.stray_q_lsb *= wall.exposure;
  used.suppressed_lsb *= wall.exposure;
  OwningConverter converter(used);
  const std::vector<std::array<double, 3>> rays = rays_of(lens);
  FrameSums sums(rays.size());
  for (std::size_t n = 0; n < wall.recording.frames.size(); ++n) {
    if (chosen(frames, n)) {
      sums.add(converter->convert(wall.recording.samples(n)), middle_of(lens));
    }
  }
  const dataset::Image<float> empty(lens.width, lens.height, kNoValue);
  WallView view{.error_m = kNothing,
                .spread_m = kNothing,
                .predicted_m = kNothing,
                .z_m = empty,
                .modulation = empty,
                .valid_share = empty};
  put_maps(sums, rays, view);
  put_middle(sums, rays, lens, wall.z_m, turn, view);
  return view;
}

}  // namespace stof::host

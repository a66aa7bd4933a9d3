#include "host/calibrate/pmd_judge.h"

#include <cmath>
#include <limits>

#include "dsp/base/arena.h"
#include "dsp/pmd/converter.h"
#include "host/calibrate/fit/pmd_model.h"
#include "host/evaluate/workspace.h"

namespace stof::host {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

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
  double mean() const { return sum / count; }
  double variance_sum() const { return std::max(squares - sum * sum / count, 0.0); }
};

// Light that is always there grows with the integration time of the recording.
dsp::PmdSensor exposed(dsp::PmdSensor sensor, double exposure) {
  sensor.frequency.stray_i_lsb *= exposure;
  sensor.frequency.stray_q_lsb *= exposure;
  sensor.suppressed_lsb *= exposure;
  return sensor;
}

WallScore score_of(const std::vector<Series>& pixels,
                   const std::vector<std::array<double, 3>>& rays, double readings, double z_m) {
  WallScore score{.z_m = z_m, .error_m = kNothing, .spread_m = kNothing, .predicted_m = kNothing};
  double count = 0, error = 0, freedom = 0, variance = 0, predicted = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const Series& pixel = pixels[p];
    if (pixel.count == 0) {
      continue;
    }
    count += pixel.count;
    error += pixel.sum * rays[p][2] - pixel.count * z_m;
    if (pixel.count > 1) {
      freedom += pixel.count - 1;
      variance += pixel.variance_sum();
      predicted += (pixel.count - 1) * pixel.sigma_squares / pixel.count;
    }
  }
  score.valid = readings > 0 ? count / readings : 0;
  if (count > 0) {
    score.error_m = error / count;
  }
  if (freedom > 0) {
    score.spread_m = std::sqrt(variance / freedom);
    score.predicted_m = std::sqrt(predicted / freedom);
  }
  return score;
}

}  // namespace

WallScore judge(const dsp::PmdSensor& sensor, const WallRecording& wall, Frames frames) {
  const dsp::Pinhole& lens = sensor.lens;
  const dsp::PmdSensor used = exposed(sensor, wall.exposure);
  Workspace space(
      dsp::bytes_taken([&](dsp::Arena& arena) noexcept { dsp::Converter(used, arena); }));
  dsp::Arena arena = space.arena();
  dsp::Converter converter(used, arena);
  const std::vector<std::array<double, 3>> rays = rays_of(lens);
  const Middle middle = middle_of(lens);
  std::vector<Series> pixels(rays.size());
  double readings = 0;
  for (std::size_t n = 0; n < wall.recording.frames.size(); ++n) {
    if (!chosen(frames, n)) {
      continue;
    }
    const dsp::PmdMaps& maps = converter.convert(wall.recording.samples(n));
    for (int y = middle.top; y < middle.bottom; ++y) {
      const std::span<const dsp::QuarterMm> distance = maps.distance.row(y);
      const std::span<const dsp::QuarterMm> sigma = maps.sigma.row(y);
      for (int x = middle.left; x < middle.right; ++x) {
        const std::size_t at = static_cast<std::size_t>(x);
        readings += 1;
        if (distance[at] != dsp::kNoDepth) {
          pixels[static_cast<std::size_t>(y * lens.width + x)].add(
              static_cast<double>(distance[at]) / dsp::kQuarterMmPerMetre,
              static_cast<double>(sigma[at]) / dsp::kQuarterMmPerMetre);
        }
      }
    }
  }
  return score_of(pixels, rays, readings, wall.z_m);
}

}  // namespace stof::host

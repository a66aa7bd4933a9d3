#include "host/evaluate/pmd/lights.h"

#include <algorithm>
#include <cmath>

#include "host/calibrate/fit/pmd_model.h"
#include "host/evaluate/owning_converter.h"
#include "host/evaluate/pmd/recordings/truth.h"

namespace stof::host {
namespace {

constexpr int kBlock = 8;

// Of one pixel or block, over the frames.
struct Errors {
  double sum = 0;
  double count = 0;
  double mean() const { return count > 0 ? sum / count : 0; }
};

struct Means {
  double pixels_m = 0;
  double blocks_m = 0;
  int pixels = 0;
};

// Radial truth of every pixel: the map that comes with the recording, else the wall's plane.
std::vector<double> radial_truth(const RangeMaps& maps, const dsp::Pinhole& lens, double z_m) {
  std::vector<double> truth;
  if (!maps.middle.pixels.empty()) {
    truth.assign(maps.middle.pixels.begin(), maps.middle.pixels.end());
    return truth;
  }
  for (const std::array<double, 3>& ray : rays_of(lens)) {
    truth.push_back(ray[2] > 0 ? z_m / ray[2] : 0);
  }
  return truth;
}

Means judge(const dsp::PmdSensor& sensor, const dataset::PmdRecording& recording,
            const std::vector<double>& truth) {
  OwningConverter converter(sensor);
  const int w = sensor.lens.width;
  const int blocks_across = (w + kBlock - 1) / kBlock;
  const int blocks_down = (sensor.lens.height + kBlock - 1) / kBlock;
  std::vector<Errors> pixels(truth.size());
  std::vector<Errors> blocks(static_cast<std::size_t>(blocks_across * blocks_down));
  for (std::size_t n = 0; n < recording.frames.size(); ++n) {
    const dsp::PmdMaps& maps = converter->convert(recording.samples(n));
    for (int i = 0; i < static_cast<int>(truth.size()); ++i) {
      const dsp::QuarterMm d = maps.distance.at(i % w, i / w);
      if (d == dsp::kNoDepth) {
        continue;
      }
      const std::size_t p = static_cast<std::size_t>(i);
      const int block = i / w / kBlock * blocks_across + i % w / kBlock;
      for (Errors* errors : {&pixels[p], &blocks[static_cast<std::size_t>(block)]}) {
        errors->sum += static_cast<double>(d) / dsp::kQuarterMmPerMetre - truth[p];
        errors->count += 1;
      }
    }
  }
  Means means;
  for (const Errors& pixel : pixels) {
    if (2 * pixel.count >= static_cast<double>(recording.frames.size())) {
      means.pixels_m += std::abs(pixel.mean());
      ++means.pixels;
    }
  }
  means.pixels_m /= std::max(means.pixels, 1);
  double seen = 0;
  for (const Errors& block : blocks) {
    means.blocks_m += std::abs(block.mean());
    seen += block.count > 0 ? 1 : 0;
  }
  means.blocks_m /= std::max(seen, 1.0);
  return means;
}

}  // namespace

dataset::Loaded<LightStudy> study_lights(const PmdSet& set, const PmdSources& sources) {
  LightStudy study{.folder = set.folder, .rows = {}};
  for (const std::filesystem::path& prefix : set.prefixes) {
    const dataset::Loaded<PmdScene> scene = read_pmd_scene(prefix, sources);
    if (!scene) {
      return std::unexpected(scene.error());
    }
    dsp::PmdSensor sensor = scene->recording.calibration.pmd;
    const dataset::Loaded<RangeMaps> maps = read_range_maps(prefix, scene->setup, sensor.lens);
    if (!maps) {
      return std::unexpected(maps.error());
    }
    const double z_m = scene->setup.z_m.value_or(0);
    const std::vector<double> truth = radial_truth(*maps, sensor.lens, z_m);
    const Means after = judge(sensor, scene->recording, truth);
    sensor.emitter_count = 0;
    const Means before = judge(sensor, scene->recording, truth);
    study.rows.push_back({.name = scene->name,
                          .z_m = z_m,
                          .before_m = before.pixels_m,
                          .after_m = after.pixels_m,
                          .before_blocks_m = before.blocks_m,
                          .after_blocks_m = after.blocks_m,
                          .pixels = after.pixels});
  }
  std::ranges::sort(study.rows, {}, &LightRow::z_m);
  return study;
}

}  // namespace stof::host

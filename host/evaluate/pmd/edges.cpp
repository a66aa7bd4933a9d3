#include "host/evaluate/pmd/edges.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dataset/files/file.h"
#include "host/calibrate/fit/pmd_model.h"
#include "host/evaluate/owning_converter.h"

namespace stof::host {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

double metres(dsp::QuarterMm value) { return static_cast<double>(value) / dsp::kQuarterMmPerMetre; }

bool beside_mixed(const dataset::Image<std::uint8_t>& mixed, int x, int y) {
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, mixed.height - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, mixed.width - 1); ++u) {
      if (mixed.pixels[static_cast<std::size_t>(v * mixed.width + u)] != 0) {
        return true;
      }
    }
  }
  return false;
}

long flagged(const dsp::PmdMaps& maps, int x, int y) {
  return (maps.flags.at(x, y) & dsp::kPmdEdge) != 0 ? 1 : 0;
}

void count_mixed(const dsp::PmdMaps& maps, const RangeMaps& truth, int x, int y,
                 EdgeCounts& counts) {
  const double short_by = std::max(metres(maps.low.at(x, y)) - truth.nearest.view().at(x, y),
                                   truth.farthest.view().at(x, y) - metres(maps.high.at(x, y)));
  ++counts.mixed_with_depth;
  counts.mixed_flagged += flagged(maps, x, y);
  counts.holding += short_by <= 0 ? 1 : 0;
  counts.worst_m = std::max(counts.worst_m, short_by);
  counts.worst_sigmas = std::max(counts.worst_sigmas, short_by / metres(maps.sigma.at(x, y)));
}

void count_pure(const dsp::PmdMaps& maps, const RangeMaps& truth, int x, int y,
                EdgeCounts& counts) {
  ++counts.pure_with_depth;
  counts.pure_flagged += flagged(maps, x, y);
  if (!truth.middle.pixels.empty()) {
    const double middle = truth.middle.view().at(x, y);
    counts.pure_error_m.push_back(std::abs(metres(maps.distance.at(x, y)) - middle));
    counts.pure_holding +=
        metres(maps.low.at(x, y)) <= middle && middle <= metres(maps.high.at(x, y)) ? 1 : 0;
  }
}

// Nearest and farthest reading of the 3x3 around a pixel that has one.
std::pair<double, double> extremes(const dsp::PmdMaps& maps, int x, int y) {
  dsp::QuarterMm least = dsp::kMaxQuarterMm;
  dsp::QuarterMm most = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, maps.distance.height() - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, maps.distance.width() - 1); ++u) {
      if (const dsp::QuarterMm d = maps.distance.at(u, v); d != dsp::kNoDepth) {
        least = std::min(least, d);
        most = std::max(most, d);
      }
    }
  }
  return {metres(least), metres(most)};
}

EdgeSection section_of(const dsp::PmdMaps& maps, const RangeMaps& truth,
                       const dataset::Image<std::uint8_t>& mixed, int y) {
  EdgeSection section;
  section.row = y;
  for (int x = 0; x < mixed.width; ++x) {
    const bool valid = maps.distance.at(x, y) != dsp::kNoDepth;
    const auto [least, most] = extremes(maps, x, y);
    section.reading.push_back(valid ? metres(maps.distance.at(x, y)) : kNothing);
    section.least.push_back(valid ? least : kNothing);
    section.most.push_back(valid ? most : kNothing);
    section.low.push_back(valid ? metres(maps.low.at(x, y)) : kNothing);
    section.high.push_back(valid ? metres(maps.high.at(x, y)) : kNothing);
    section.nearest.push_back(truth.nearest.view().at(x, y));
    section.farthest.push_back(truth.farthest.view().at(x, y));
    section.mixed.push_back(mixed.view().at(x, y));
    section.flagged.push_back(static_cast<std::uint8_t>(flagged(maps, x, y)));
  }
  return section;
}

// The row with most mixed pixels that carry a distance.
int row_of_most(const dsp::PmdMaps& maps, const dataset::Image<std::uint8_t>& mixed) {
  int best = mixed.height / 2;
  int most = 0;
  for (int y = 0; y < mixed.height; ++y) {
    int count = 0;
    for (int x = 0; x < mixed.width; ++x) {
      const bool valid = maps.distance.at(x, y) != dsp::kNoDepth;
      count += valid && mixed.view().at(x, y) != 0 ? 1 : 0;
    }
    if (count > most) {
      most = count;
      best = y;
    }
  }
  return best;
}

void keep_pictures(const PmdScene& scene, const dsp::PmdMaps& maps, const RangeMaps& truth,
                   const dataset::Image<std::uint8_t>& mixed, EdgeStudy& study) {
  constexpr double kWhite = 255;
  const int w = mixed.width;
  const int h = mixed.height;
  const std::vector<std::array<double, 3>> rays = rays_of(scene.recording.calibration.pmd.lens);
  study.section = section_of(maps, truth, mixed, row_of_most(maps, mixed));
  study.section.name = scene.name;
  study.z_m = dataset::Image<float>(w, h, std::numeric_limits<float>::infinity());
  study.amplitude = dataset::Image<std::uint8_t>(w, h);
  study.marks = mixed;
  double brightest = 1;
  for (int y = 0; y < h; ++y) {
    brightest = std::max<double>(brightest, std::ranges::max(maps.amp2.row(y)));
  }
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const std::size_t i = static_cast<std::size_t>(y * w + x);
      const bool valid = maps.distance.at(x, y) != dsp::kNoDepth;
      if (valid) {
        study.z_m.pixels[i] = static_cast<float>(metres(maps.distance.at(x, y)) * rays[i][2]);
      }
      study.amplitude.pixels[i] =
          static_cast<std::uint8_t>(kWhite * std::sqrt(maps.amp2.at(x, y) / brightest));
      study.marks.pixels[i] =
          static_cast<std::uint8_t>(mixed.pixels[i] + 2 * flagged(maps, x, y) + (valid ? 0 : 4));
    }
  }
}

}  // namespace

EdgeCounts& EdgeCounts::operator+=(const EdgeCounts& other) {
  mixed += other.mixed;
  mixed_with_depth += other.mixed_with_depth;
  mixed_flagged += other.mixed_flagged;
  holding += other.holding;
  pure += other.pure;
  pure_with_depth += other.pure_with_depth;
  pure_flagged += other.pure_flagged;
  pure_flagged_beside += other.pure_flagged_beside;
  pure_beside += other.pure_beside;
  pure_holding += other.pure_holding;
  pure_error_m.insert(pure_error_m.end(), other.pure_error_m.begin(), other.pure_error_m.end());
  worst_m = std::max(worst_m, other.worst_m);
  worst_sigmas = std::max(worst_sigmas, other.worst_sigmas);
  return *this;
}

EdgeCounts count_edges(const dsp::PmdMaps& maps, const RangeMaps& truth,
                       const dataset::Image<std::uint8_t>& mixed) {
  EdgeCounts counts;
  for (int y = 0; y < mixed.height; ++y) {
    for (int x = 0; x < mixed.width; ++x) {
      const bool is_mixed = mixed.view().at(x, y) != 0;
      ++(is_mixed ? counts.mixed : counts.pure);
      if (maps.distance.at(x, y) == dsp::kNoDepth) {
        continue;
      }
      if (is_mixed) {
        count_mixed(maps, truth, x, y, counts);
      } else {
        count_pure(maps, truth, x, y, counts);
        if (beside_mixed(mixed, x, y)) {
          ++counts.pure_beside;
          counts.pure_flagged_beside += flagged(maps, x, y);
        }
      }
    }
  }
  return counts;
}

dataset::Loaded<EdgeStudy> study_edges(const PmdSet& set, const PmdSources& sources) {
  EdgeStudy study;
  study.folder = set.folder;
  long most_mixed = -1;
  for (const std::filesystem::path& prefix : set.prefixes) {
    const dataset::Loaded<PmdScene> scene = read_pmd_scene(prefix, sources);
    if (!scene) {
      return std::unexpected(scene.error());
    }
    const dsp::PmdSensor& sensor = scene->recording.calibration.pmd;
    const dataset::Loaded<RangeMaps> truth = read_range_maps(prefix, scene->setup, sensor.lens);
    if (!truth) {
      return std::unexpected(truth.error());
    }
    if (truth->nearest.pixels.empty() || truth->farthest.pixels.empty()) {
      return dataset::refuse(prefix.string() +
                             "_r_min.pgm: is absent, or r_max is: give both maps of the recording");
    }
    const dataset::Image<std::uint8_t> mixed = mixed_pixels(*truth);
    OwningConverter converter(sensor);
    EdgeRow row{
        .name = scene->name, .edge_m = scene->setup.edge_m.value_or(kNothing), .counts = {}};
    for (std::size_t n = 0; n < scene->recording.frames.size(); ++n) {
      row.counts += count_edges(converter->convert(scene->recording.samples(n)), *truth, mixed);
    }
    if (row.counts.mixed > most_mixed) {
      most_mixed = row.counts.mixed;
      keep_pictures(*scene, converter->convert(scene->recording.samples(0)), *truth, mixed, study);
    }
    study.all += row.counts;
    study.rows.push_back(std::move(row));
  }
  return study;
}

}  // namespace stof::host

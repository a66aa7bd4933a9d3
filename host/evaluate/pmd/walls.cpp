#include "host/evaluate/pmd/walls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/calibrate/walls/wall_folder.h"

namespace stof::host {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();
constexpr double kRatioOne = 256;  // PmdMaps::ratio
constexpr double kShownM = 2;      // walls of about this distance are drawn

dsp::PmdSensor exposed(dsp::PmdSensor sensor, double exposure) {
  sensor.frequency.stray_i_lsb *= exposure;
  sensor.frequency.stray_q_lsb *= exposure;
  sensor.suppressed_lsb *= exposure;
  return sensor;
}

// Sums over the frames of one recording.
struct Sums {
  explicit Sums(std::size_t pixels)
      : distance(pixels), sigma(pixels), valid(pixels), modulation(pixels) {}
  std::vector<double> distance, sigma, valid, modulation;
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
          valid[p] += 1;
          distance[p] += static_cast<double>(maps.distance.at(x, y)) / dsp::kQuarterMmPerMetre;
          sigma[p] += static_cast<double>(maps.sigma.at(x, y)) / dsp::kQuarterMmPerMetre;
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

WallView view_of(const Sums& sums, const std::vector<std::array<double, 3>>& rays,
                 const dsp::Pinhole& lens, double z_m) {
  const dataset::Image<float> empty(lens.width, lens.height, kNoValue);
  WallView view{.error_m = kNothing,
                .z_m = empty,
                .sigma_m = empty,
                .modulation = empty,
                .valid_share = empty};
  const Middle middle = middle_of(lens);
  double count = 0;
  double error = 0;
  for (std::size_t p = 0; p < rays.size(); ++p) {
    view.modulation.pixels[p] = static_cast<float>(sums.modulation[p] / sums.frames);
    view.valid_share.pixels[p] = static_cast<float>(sums.valid[p] / sums.frames);
    if (sums.valid[p] == 0) {
      continue;
    }
    view.z_m.pixels[p] = static_cast<float>(sums.distance[p] / sums.valid[p] * rays[p][2]);
    view.sigma_m.pixels[p] = static_cast<float>(sums.sigma[p] / sums.valid[p]);
    if (middle.holds(static_cast<int>(p) % lens.width, static_cast<int>(p) / lens.width)) {
      count += sums.valid[p];
      error += sums.distance[p] * rays[p][2] - sums.valid[p] * z_m;
    }
  }
  if (count > 0) {
    view.error_m = error / count;
  }
  if (sums.readings > 0) {
    view.valid = count / sums.readings;
    view.ratio = sums.ratio / sums.readings;
    view.amp2 = sums.amp2 / sums.readings;
    std::ranges::transform(sums.flagged, view.flagged.begin(),
                           [&sums](double flagged) { return flagged / sums.readings; });
  }
  return view;
}

// The recordings' own constants, with the phasor alone estimated from the chosen frames.
std::expected<void, dataset::Problem> study_stray(const WallFolder& folder,
                                                  const PmdSources& sources, Frames fitted,
                                                  WallStudy& study) {
  const dataset::Loaded<PmdScene> scene = read_pmd_scene(folder.prefixes.front(), sources);
  if (!scene) {
    return std::unexpected(scene.error());
  }
  const dsp::PmdSensor own = scene->recording.calibration.pmd;
  const CalibrateOptions options{.parts = {.offset = false,
                                           .scale = false,
                                           .wiggling = false,
                                           .pattern = false,
                                           .stray = true,
                                           .emitter = false},
                                 .noise = false,
                                 .white = false,
                                 .start = own,
                                 .phase_falls = own.phase_falls};
  const dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(own, std::vector<Wall>(folder.walls), options);
  if (!found) {
    return std::unexpected(dataset::Problem{folder.prefixes.front().parent_path().string() + ": " +
                                            found.error().message});
  }
  study.stray_i_lsb = found->stray.estimate.real();
  study.stray_q_lsb = found->stray.estimate.imag();
  study.stray_sigma_lsb = found->stray.sigma;
  study.stray_apparent_m = found->stray.apparent_m;
  dsp::PmdSensor with = own;
  with.frequency.stray_i_lsb = study.stray_i_lsb;
  with.frequency.stray_q_lsb = study.stray_q_lsb;
  for (std::size_t n = 0; n < folder.prefixes.size(); ++n) {
    const dataset::Loaded<WallRecording> wall = read_again(folder, n);
    if (!wall) {
      return std::unexpected(wall.error());
    }
    study.stray.push_back({.name = wall->name,
                           .z_m = wall->z_m,
                           .before = view_wall(own, *wall, others(fitted)),
                           .after = view_wall(with, *wall, others(fitted))});
  }
  std::ranges::sort(study.stray, {}, &StrayRow::z_m);
  return {};
}

std::expected<void, dataset::Problem> add_views(const WallFolder& folder, Frames judged,
                                                WallStudy& study) {
  dsp::PmdSensor bare = study.calibration.sensor;
  bare.frequency.wiggling = {};
  bare.frequency.stray_i_lsb = bare.frequency.stray_q_lsb = 0;
  bare.fixed_pattern = {};
  bare.emitter_count = 0;
  bare.scale = 1;
  bare.frequency.offset_m = bare.shift_m = 0;
  study.views.resize(study.report.rows.size());
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < folder.prefixes.size(); ++n) {
    const dataset::Loaded<WallRecording> wall = read_again(folder, n);
    if (!wall) {
      return std::unexpected(wall.error());
    }
    const auto row = std::ranges::find(study.report.rows, wall->name, &WallRow::name);
    WallView view = view_wall(study.calibration.sensor, *wall, judged);
    if (std::abs(wall->z_m - kShownM) < nearest) {
      nearest = std::abs(wall->z_m - kShownM);
      study.shown = wall->name;
      study.shown_m = wall->z_m;
      study.plain = view_wall(bare, *wall, judged);
      study.full = view;
    }
    study.views[static_cast<std::size_t>(row - study.report.rows.begin())] = std::move(view);
  }
  return {};
}

}  // namespace

const std::array<const char*, kPmdFlags>& pmd_flag_names() {
  static constexpr std::array<const char*, kPmdFlags> kNames{
      "saturated",  "under range", "low amplitude", "low ratio",
      "asymmetric", "edge",        "out of range",  "wrapped"};
  return kNames;
}

WallView view_wall(const dsp::PmdSensor& sensor, const WallRecording& wall, Frames frames) {
  const dsp::PmdSensor used = exposed(sensor, wall.exposure);
  OwnConverter converter(used);
  const std::vector<std::array<double, 3>> rays = rays_of(used.lens);
  const Middle middle = middle_of(used.lens);
  Sums sums(rays.size());
  for (std::size_t n = 0; n < wall.recording.frames.size(); ++n) {
    if (chosen(frames, n)) {
      sums.add(converter->convert(wall.recording.samples(n)), middle);
    }
  }
  return view_of(sums, rays, used.lens, wall.z_m);
}

dataset::Loaded<WallStudy> study_walls(const PmdSet& set, const PmdSources& sources,
                                       Frames fitted) {
  const dataset::Loaded<WallFolder> folder = read_folder(set.folder, fitted);
  if (!folder) {
    return std::unexpected(folder.error());
  }
  dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(folder->calibration.pmd, std::vector<Wall>(folder->walls), CalibrateOptions{});
  if (!found) {
    return std::unexpected(dataset::Problem{set.folder.string() + ": " + found.error().message});
  }
  WallStudy study;
  study.folder = set.folder;
  study.calibration = std::move(*found);
  if (sources.calibration) {
    const dsp::PmdSensor& known = *sources.calibration;
    const dsp::PmdSensor& own = study.calibration.sensor;
    study.given = known.lens.width == own.lens.width && known.lens.height == own.lens.height &&
                  known.frequency.modulation.value == own.frequency.modulation.value;
    study.calibration.sensor = study.given ? known : own;
  }
  const Frames judged_by = study.given ? Frames::kAll : fitted;
  dataset::Loaded<PmdReport> report = make_report(*folder, judged_by, study.calibration);
  if (!report) {
    return std::unexpected(std::move(report.error()));
  }
  study.report = std::move(*report);
  study.report.folder = set.folder.string();
  if (auto viewed = add_views(*folder, study.report.judged, study); !viewed) {
    return std::unexpected(std::move(viewed.error()));
  }
  if (study.calibration.stray.verdict == StrayVerdict::kCorrected) {
    if (auto looked = study_stray(*folder, sources, fitted, study); !looked) {
      return std::unexpected(std::move(looked.error()));
    }
  }
  return study;
}

}  // namespace stof::host

#include "host/calibrate/pmd_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "dataset/files/file.h"
#include "host/calibrate/fit/initial_estimate.h"
#include "host/calibrate/fit/pmd_measures.h"

namespace stof::host {
namespace {

constexpr std::size_t kFewestForStray = 4;
constexpr std::size_t kEnoughPixels = 4096;
constexpr std::size_t kEnoughForAWall = 64;
// A constant is kept when it explains this share of the misfit, and is this many times its
// standard deviation. Millions of samples make anything significant; below these shares it is the
// model's own error that is explained.
constexpr double kStrayShare = 0.05;
constexpr double kScaleShare = 0.02;
constexpr double kEmitterShare = 0.02;
constexpr double kWallTurnShare = 0.02;
constexpr double kWallShare = 0.03;
constexpr double kAsLikely = 0.5;       // of what the likeliest wall explains
constexpr double kLeastShiftM = 0.015;  // of a wall, beyond what a tape is read to
constexpr double kSimpler = 0.6;        // times the energy of the wiggling
constexpr double kSignificant = 5;

SampleNoise noise_of(const dsp::PmdSensor& sensor) {
  return {.electrons_per_lsb = sensor.electrons_per_lsb,
          .noise_lsb = sensor.noise_lsb,
          .suppressed_lsb = sensor.suppressed_lsb};
}

double gain(const FitResult& before, const FitResult& after) {
  return before.cost > 0 ? (before.cost - after.cost) / before.cost : 0;
}

// The steps of a calibration, each of which may see what the ones before it found.
class Steps {
 public:
  Steps(const dsp::PmdSensor& camera, std::vector<Wall> walls, const CalibrateOptions& options)
      : options_(options), parts_(options.parts) {
    out_.sensor = options.start.value_or(camera);
    WallData& data = out_.data;
    data.lens = camera.lens;
    data.rays = rays_of(camera.lens);
    data.walls = std::move(walls);
    data.min_amplitude_lsb = out_.sensor.min_amplitude_lsb;
    data.every = static_cast<int>((data.rays.size() + kEnoughPixels - 1) / kEnoughPixels);
    begin_ = model_of(out_.sensor);
    if (camera.emitter_count > 0) {
      begin_.emitters.assign(camera.emitters.begin(),
                             camera.emitters.begin() + camera.emitter_count);
    }
    parts_.emitter &= begin_.emitters.empty();
    begin_.phase_falls = options.phase_falls.value_or(begin_.phase_falls);
    forget_what_is_estimated();
  }

  PmdCalibration run() {
    fit_the_noise();
    begin();
    FitParts plain = parts_;
    plain.scale = plain.stray = plain.emitter = plain.wall_turn = false;
    best_ = fit_model(out_.data, plain, begin_);
    out_.parts = plain;
    judge_stray(plain);
    try_scale();
    try_emitter_and_wall_turn();
    confirm_stray();
    judge_walls();
    finish();
    return std::move(out_);
  }

 private:
  void forget_what_is_estimated() {
    if (parts_.offset) {
      begin_.offset = 0;
      begin_.shift_m = 0;
    }
    if (parts_.scale) {
      begin_.scale = 1;
    }
    if (parts_.wiggling) {
      begin_.wiggling = {};
    }
    if (parts_.pattern) {
      begin_.pattern.clear();
    }
    if (parts_.stray) {
      begin_.stray = 0;
    }
  }

  void fit_the_noise() {
    WallData& data = out_.data;
    data.noise = noise_of(out_.sensor);
    if (!options_.noise) {
      return;
    }
    if (const std::optional<SampleNoise> found = fit_noise(data.walls, data.noise)) {
      data.noise = *found;
      out_.noise_fitted = true;
    }
  }

  bool stray_can_be_seen() const { return out_.data.walls.size() >= kFewestForStray; }

  // Sign and offset, with stray light in the equations wherever it can be told from the signal:
  // it may bend phases until they fall with distance.
  void begin() {
    const bool known = options_.phase_falls.has_value() || options_.start.has_value();
    PmdModel guessed = begin_;
    estimate_initial_model(out_.data, known, stray_can_be_seen() && begin_.stray == 0.0, guessed);
    begin_.phase_falls = guessed.phase_falls;
    if (parts_.offset) {
      begin_.offset = guessed.offset;
    }
    stray_guess_ = guessed.stray;
  }

  FitResult with_stray(const FitParts& plain, const PmdModel& from) const {
    FitParts parts = plain;
    parts.stray = true;
    PmdModel model = from;
    model.stray = stray_guess_;
    return fit_model(out_.data, parts, model);
  }

  // Both with everything else that bends phases: only what that does not explain is stray light.
  void judge_stray(const FitParts& plain) {
    if (!stray_can_be_seen() || begin_.stray != 0.0) {
      return;
    }
    FitParts full = plain;
    if (!options_.start) {
      full.offset = full.wiggling = full.pattern = true;
    }
    const bool same = full.wiggling == plain.wiggling && full.pattern == plain.pattern &&
                      full.offset == plain.offset;
    const FitResult without = same ? best_ : fit_model(out_.data, full, begin_);
    FitResult with = with_stray(full, begin_);
    StrayReport& report = out_.stray;
    report.estimate = with.model.stray;
    report.sigma = with.stray_sigma;
    report.explains = gain(without, with);
    report.apparent_m = apparent_distance(with.model);
    const bool seen =
        report.explains >= kStrayShare && std::abs(report.estimate) > kSignificant * report.sigma;
    report.verdict = StrayVerdict::kNone;
    if (seen && !parts_.stray) {
      report.verdict = StrayVerdict::kSuspected;
    } else if (seen) {
      report.verdict = StrayVerdict::kCorrected;
      best_ = same ? std::move(with) : with_stray(plain, begin_);
      out_.parts.stray = true;
    }
  }

  static double apparent_distance(const PmdModel& model) {
    const double sign = model.phase_falls ? -1 : 1;
    const double phi1 = sign * std::arg(model.stray) / (2 * std::numbers::pi) - model.offset;
    const double phi2 = phi1 - model.wiggling.at(phi1);
    return (phi2 - std::floor(phi2)) * model.turn_m * model.scale + model.shift_m;
  }

  // A light beside the lens makes a ramp over the picture, as large at each wall; walls that do not
  // face the camera one that grows with distance. Each alone looks like some of the other: what
  // explains more is asked first.
  void try_emitter_and_wall_turn() {
    std::optional<Step> light = parts_.emitter ? std::optional(with_emitter()) : std::nullopt;
    std::optional<Step> turn = parts_.wall_turn ? std::optional(with_wall_turn()) : std::nullopt;
    const bool turn_first = turn && (!light || turn->fit.cost < light->fit.cost);
    const std::array order{turn_first ? &turn : &light, turn_first ? &light : &turn};
    if (*order[0] && take(**order[0]) && *order[1]) {
      *order[1] = turn_first ? with_emitter() : with_wall_turn();
    }
    if (*order[1]) {
      take(**order[1]);
    }
  }

  // One constant more, and whether the walls ask for it.
  struct Step {
    FitParts parts;
    FitResult fit;
    bool asked = false;
  };

  bool take(Step& step) {
    if (step.asked) {
      best_ = std::move(step.fit);
      out_.parts = step.parts;
    }
    return step.asked;
  }

  Step with_emitter() const {
    Step step{.parts = out_.parts, .fit = {}};
    step.parts.emitter = true;
    PmdModel model = best_.model;
    model.emitters = {dsp::Emitter{}};
    step.fit = fit_model(out_.data, step.parts, model);
    step.asked = gain(best_, step.fit) >= kEmitterShare;
    return step;
  }

  Step with_wall_turn() const {
    Step step{.parts = out_.parts, .fit = {}};
    step.parts.wall_turn = true;
    step.fit = fit_model(out_.data, step.parts, best_.model);
    const std::array<double, 2>& turn = step.fit.model.wall_turn;
    step.asked = gain(best_, step.fit) >= kWallTurnShare &&
                 std::hypot(turn[0], turn[1]) > kSignificant * step.fit.wall_turn_sigma;
    return step;
  }

  // A straight line of another slope is much like harmonics of all orders, except where the phase
  // wraps. Of two that explain the walls alike, the one with less wiggling is the simpler.
  void try_scale() {
    if (!parts_.scale) {
      return;
    }
    FitParts parts = out_.parts;
    parts.scale = true;
    FitResult found = fit_model(out_.data, parts, best_.model);
    const double gained = gain(best_, found);
    const bool simpler = parts.wiggling && gained > -kScaleShare &&
                         energy(found.model.wiggling) < kSimpler * energy(best_.model.wiggling);
    const bool telling = std::abs(found.model.scale - 1) > kSignificant * found.scale_sigma;
    if (telling && (gained >= kScaleShare || simpler)) {
      best_ = std::move(found);
      out_.parts = parts;
    }
  }

  // What looked like stray light may have been the lights or the line.
  void confirm_stray() {
    const bool more = out_.parts.scale || out_.parts.emitter;
    if (out_.stray.verdict != StrayVerdict::kCorrected || !more) {
      return;
    }
    FitParts parts = out_.parts;
    parts.stray = false;
    PmdModel model = best_.model;
    model.stray = 0;
    FitResult without = fit_model(out_.data, parts, model);
    out_.stray.explains = gain(without, best_);
    out_.stray.estimate = best_.model.stray;
    if (out_.stray.explains < kStrayShare) {
      best_ = std::move(without);
      out_.parts = parts;
      out_.stray.verdict = StrayVerdict::kNone;
    }
  }

  // A wall whose distance is mistyped is explained by the wiggling, at the price of all walls. So
  // each in turn may stand elsewhere: of a wrong one that explains much. Some dozen pixels tell.
  void judge_walls() {
    WallData& data = out_.data;
    const int every = data.every;
    data.every = std::max(
        every, static_cast<int>((data.rays.size() + kEnoughForAWall - 1) / kEnoughForAWall));
    const FitResult all = fit_model(data, out_.parts, best_.model);
    std::vector<WrongWall> wrong;
    bool certain = false;  // that one of them is
    for (std::size_t w = 0; w < data.walls.size(); ++w) {
      FitParts parts = out_.parts;
      parts.shifted_wall = w;
      const FitResult freed = fit_model(data, parts, best_.model);
      const double shift = freed.model.wall_shift_m;
      const double sigma = freed.wall_shift_sigma * std::max(1.0, misfit_of(freed));
      const double explains = gain(all, freed);
      if (std::abs(shift) > kLeastShiftM) {
        certain |= explains >= kWallShare && std::abs(shift) > kSignificant * sigma;
        wrong.push_back({.name = data.walls[w].name,
                         .z_m = data.walls[w].z_m,
                         .likely_m = data.walls[w].z_m + shift,
                         .sigma_m = sigma,
                         .explains = explains});
      }
    }
    data.every = every;
    if (!certain) {
      return;
    }
    std::ranges::sort(wrong, std::ranges::greater(), &WrongWall::explains);
    std::erase_if(wrong, [most = wrong.front().explains](const WrongWall& wall) {
      return wall.explains < kAsLikely * most;
    });
    out_.wrong_walls = std::move(wrong);
  }

  static double misfit_of(const FitResult& fit) {
    return std::sqrt(2 * fit.cost / static_cast<double>(std::max<std::size_t>(fit.readings, 1)));
  }

  static double energy(const WigglingCurve& curve) {
    double sum = 0;
    for (std::size_t h = 0; h < curve.sine.size(); ++h) {
      sum += curve.cosine[h] * curve.cosine[h] + curve.sine[h] * curve.sine[h];
    }
    return sum;
  }

  // The pattern of the pixels that were not looked at.
  void complete_pattern() {
    WallData& data = out_.data;
    if (data.every == 1 || !out_.parts.pattern) {
      return;
    }
    data.every = 1;
    const FitParts pattern{.offset = false,
                           .scale = false,
                           .wiggling = false,
                           .pattern = true,
                           .stray = false,
                           .emitter = false,
                           .wall_turn = false};
    best_.model = fit_model(data, pattern, best_.model).model;
  }

  void finish() {
    out_.widest_gap = widest_gap(out_.data, best_.model);
    out_.readings = best_.readings;
    out_.misfit = misfit_of(best_);
    out_.scale_sigma = best_.scale_sigma;
    complete_pattern();
    out_.line = fit_line(out_.data, best_.model);
    out_.sigma = measured_sigma(out_.data, best_.model);
    put_model(best_.model, out_.sensor, out_.pattern);
    out_.noise = out_.data.noise;
    if (out_.noise_fitted) {
      out_.sensor.electrons_per_lsb = out_.noise.electrons_per_lsb;
      out_.sensor.noise_lsb = out_.noise.noise_lsb;
      out_.sensor.suppressed_lsb = out_.noise.suppressed_lsb;
    }
    if (options_.white) {
      out_.sensor.white_lsb = white_amplitude(out_.data, best_.model, options_.albedo);
    }
    out_.model = std::move(best_.model);
  }

  const CalibrateOptions options_;
  FitParts parts_;
  PmdModel begin_;
  std::complex<double> stray_guess_;
  FitResult best_;
  PmdCalibration out_;
};

}  // namespace

dataset::Loaded<PmdCalibration> calibrate_pmd(const dsp::PmdSensor& camera, std::vector<Wall> walls,
                                              const CalibrateOptions& options) {
  const std::size_t blind = drop_blind(walls, camera);
  if (walls.empty() && blind > 0) {
    return dataset::refuse(
        "no recording has a pixel that is neither saturated nor dark: change the "
        "integration time");
  }
  if (const std::size_t count = count_distances(walls); count < kFewestWalls) {
    return dataset::refuse("usable recordings at " + std::to_string(count) +
                           " distance(s): a calibration needs " + std::to_string(kFewestWalls) +
                           " at least (json with \"z_m\", frames, unsaturated pixels)");
  }
  return Steps(camera, std::move(walls), options).run();
}

}  // namespace stof::host

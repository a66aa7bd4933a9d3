#include "host/calibrate/fit/pmd_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/calibrate/fit/pmd_rows.h"

namespace stof::host {
namespace {

// What the model does not know: a phase is no better than 1/7000 turn, and lights are no points
// (their size and place add up to an area over the distance).
constexpr double kModelTurns = 1.5e-4;
constexpr double kLightAreaM2 = 0.004;

constexpr double kWidestPattern = 0.02;       // turns
constexpr double kNarrowestPattern = 1.0e-5;  // turns

constexpr double kSteepestWiggling = 0.8;  // turns a turn
constexpr int kMaxSteps = 60;
constexpr int kPatternRounds = 3;

double huber_cost(double r) {
  const double size = std::abs(r);
  return size <= kHuber ? r * r / 2 : kHuber * (size - kHuber / 2);
}

class Fit {
 public:
  Fit(const WallData& data, const FitParts& parts, const PmdModel& begin)
      : data_(data), parts_(parts), seen_(observations(data, begin.phase_falls)) {
    result_.model = begin;
    result_.readings = seen_.size();
    if (parts.pattern || begin.pattern.empty()) {
      result_.model.pattern.resize(data.rays.size(), 0.0);
    }
  }

  FitResult run() {
    descend();
    for (int round = 1; round < kPatternRounds && parts_.pattern; ++round) {
      measure_pattern();
      descend();
    }
    centre_pattern();
    return std::move(result_);
  }

 private:
  // A pixel's part of the normal equations.
  struct PixelSums {
    double square = 0;
    double right = 0;
    Column mixed = Column::Zero();
  };

  double cost(const PmdModel& model) const {
    double sum = 0;
    for (const Observation& o : seen_) {
      sum += huber_cost(row_of(data_, parts_, model, o).residual);
    }
    for (int k = 0; k < kUnknowns; ++k) {
      const double away = is_active(parts_, k) ? from_prior(model, k) : 0;
      sum += prior_of(k) * away * away / 2;
    }
    for (const double p : model.pattern) {
      sum += parts_.pattern ? p * p / (2 * pattern_size_ * pattern_size_) : 0;
    }
    return sum;
  }

  // A phase that does not grow with distance everywhere has no inverse.
  static bool possible(const PmdModel& model) {
    double steepest = 0;
    for (int i = 0; i < dsp::kWigglingSteps; ++i) {
      const double phi = static_cast<double>(i) / dsp::kWigglingSteps;
      steepest = std::max(steepest, std::abs(model.wiggling.slope(phi)));
    }
    return steepest < kSteepestWiggling && model.scale > 0.5 && model.scale < 2;
  }

  void gather() {
    normal_.setZero();
    right_.setZero();
    pixels_.assign(data_.rays.size(), {});
    const PmdModel& model = result_.model;
    Square own = Square::Zero();
    for (const Observation& o : seen_) {
      const Row row = row_of(data_, parts_, model, o);
      own.selfadjointView<Eigen::Lower>().rankUpdate(row.by, row.weight);
      right_ += row.weight * row.residual * row.by;
      PixelSums& pixel = pixels_[o.pixel];
      pixel.square += row.weight * row.by_pattern * row.by_pattern;
      pixel.right += row.weight * row.by_pattern * row.residual;
      pixel.mixed += row.weight * row.by_pattern * row.by;
    }
    if (parts_.pattern) {
      for (std::size_t p = 0; p < pixels_.size(); ++p) {
        PixelSums& pixel = pixels_[p];
        pixel.square += 1 / (pattern_size_ * pattern_size_);
        pixel.right += model.pattern[p] / (pattern_size_ * pattern_size_);
        own.selfadjointView<Eigen::Lower>().rankUpdate(pixel.mixed, -1 / pixel.square);
        right_ -= pixel.right / pixel.square * pixel.mixed;
      }
    }
    normal_ = own.selfadjointView<Eigen::Lower>();
    for (int k = 0; k < kUnknowns; ++k) {
      if (is_active(parts_, k)) {
        normal_(k, k) += prior_of(k);
        right_[k] += prior_of(k) * from_prior(model, k);
      } else {
        normal_.row(k).setZero();
        normal_.col(k).setZero();
        normal_(k, k) = 1;
        right_[k] = 0;
      }
    }
  }

  PmdModel stepped(double damping) const {
    Square damped = normal_;
    damped.diagonal() += damping * normal_.diagonal();
    const Column step = -damped.ldlt().solve(right_);
    PmdModel next = result_.model;
    next.offset += step[kOffset];
    next.scale += step[kScale];
    next.stray += std::complex<double>(step[kStrayI], step[kStrayQ]);
    if (parts_.emitter) {
      move_emitters(next, step[kEmitterX], step[kEmitterY]);
    }
    for (std::size_t h = 0; h < kHarmonics; ++h) {
      const int at = kFirstHarmonic + 2 * static_cast<int>(h);
      next.wiggling.cosine[h] += step[at];
      next.wiggling.sine[h] += step[at + 1];
    }
    for (std::size_t p = 0; parts_.pattern && p < pixels_.size(); ++p) {
      next.pattern[p] -= (pixels_[p].right + pixels_[p].mixed.dot(step)) / pixels_[p].square;
    }
    return next;
  }

  // What a residual is counted in. It stays while the constants move: a larger sigma must not
  // count as a better fit.
  void weigh() {
    const PmdModel& model = result_.model;
    const std::complex<double> stray = model.phase_falls ? std::conj(model.stray) : model.stray;
    for (Observation& o : seen_) {
      const double blur = kModelTurns + kLightAreaM2 / (o.distance_m * model.turn_m);
      const double signal = std::abs(o.iq - o.exposure * stray);
      o.sigma = std::hypot(std::sqrt(o.variance), kTurn * blur * signal);
    }
  }

  void descend() {
    constexpr double kSmallGain = 1e-7;
    weigh();
    double damping = 1e-6;
    double now = cost(result_.model);
    result_.converged = false;
    for (int i = 0; i < kMaxSteps && !result_.converged && damping < 1e6; ++i) {
      gather();
      while (damping < 1e6) {
        PmdModel next = stepped(damping);
        const double then = possible(next) ? cost(next) : INFINITY;
        if (then <= now) {
          result_.converged = now - then <= kSmallGain * now;
          result_.model = std::move(next);
          now = then;
          damping = std::max(damping / 10, 1e-9);
          break;
        }
        damping *= 10;
      }
    }
    result_.converged |= damping >= 1e6;  // no step is better: the bottom of what doubles resolve
    gather();
    const Square covariance = normal_.ldlt().solve(Square::Identity());
    result_.scale_sigma = std::sqrt(std::max(covariance(kScale, kScale), 0.0));
    result_.stray_sigma =
        std::sqrt(std::max({covariance(kStrayI, kStrayI), covariance(kStrayQ, kStrayQ), 0.0}));
    result_.cost = now;
  }

  // The pattern's own size: its variance less what the readings' noise adds.
  void measure_pattern() {
    double squares = 0;
    double noise = 0;
    double count = 0;
    double sum = 0;
    for (std::size_t p = 0; p < pixels_.size(); ++p) {
      const double own = pixels_[p].square - 1 / (pattern_size_ * pattern_size_);
      if (!(own > 0)) {
        continue;
      }
      const double free = result_.model.pattern[p] * pixels_[p].square / own;  // without the prior
      squares += free * free;
      sum += free;
      noise += 1 / own;
      count += 1;
    }
    if (count > 1) {
      const double variance = (squares - sum * sum / count - noise) / count;
      pattern_size_ =
          std::clamp(std::sqrt(std::max(variance, 0.0)), kNarrowestPattern, kWidestPattern);
    }
  }

  // Offset and pattern together are what is measured; the pattern's mean is 0.
  void centre_pattern() {
    if (!parts_.pattern || !parts_.offset) {
      return;
    }
    std::vector<double>& pattern = result_.model.pattern;
    double sum = 0;
    double count = 0;
    for (std::size_t p = 0; p < pattern.size(); ++p) {
      const bool known = pixels_[p].square > 1.5 / (pattern_size_ * pattern_size_);
      sum += known ? pattern[p] : 0;
      count += known ? 1 : 0;
    }
    const double mean = count > 0 ? sum / count : 0;
    for (double& value : pattern) {
      value = value == 0 ? 0 : value - mean;
    }
    result_.model.offset = wrapped(result_.model.offset + mean);
  }

  const WallData& data_;
  const FitParts parts_;
  std::vector<Observation> seen_;
  double pattern_size_ = kWidestPattern;
  FitResult result_;
  Square normal_;
  Column right_;
  std::vector<PixelSums> pixels_;
};

}  // namespace

FitResult fit_model(const WallData& data, const FitParts& parts, const PmdModel& begin) {
  return Fit(data, parts, begin).run();
}

}  // namespace stof::host

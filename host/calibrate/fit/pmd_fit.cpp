#include "host/calibrate/fit/pmd_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

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

using Unknowns = std::array<double, kUnknowns>;

// Emitters are told by how far they have moved.
Unknowns unknowns_of(const PmdModel& model) {
  Unknowns x{};
  x[kOffset] = model.offset;
  x[kScale] = model.scale;
  x[kStrayI] = model.stray.real();
  x[kStrayQ] = model.stray.imag();
  x[kWallTurnX] = model.wall_turn[0];
  x[kWallTurnY] = model.wall_turn[1];
  x[kWallShift] = model.wall_shift_m;
  for (std::size_t h = 0; h < kHarmonics; ++h) {
    x[kFirstHarmonic + 2 * h] = model.wiggling.cosine[h];
    x[kFirstHarmonic + 2 * h + 1] = model.wiggling.sine[h];
  }
  return x;
}

void put_unknowns(const Unknowns& x, const std::vector<dsp::Emitter>& emitters, PmdModel& model) {
  model.offset = x[kOffset];
  model.scale = x[kScale];
  model.stray = {x[kStrayI], x[kStrayQ]};
  model.wall_turn = {x[kWallTurnX], x[kWallTurnY]};
  model.wall_shift_m = x[kWallShift];
  model.emitters = emitters;
  move_emitters(model, x[kEmitterX], x[kEmitterY]);
  for (std::size_t h = 0; h < kHarmonics; ++h) {
    model.wiggling.cosine[h] = x[kFirstHarmonic + 2 * h];
    model.wiggling.sine[h] = x[kFirstHarmonic + 2 * h + 1];
  }
}

// A phase that does not grow with distance everywhere has no inverse.
bool possible(const PmdModel& model) {
  double steepest = 0;
  for (int i = 0; i < dsp::kWigglingSteps; ++i) {
    const double phi = static_cast<double>(i) / dsp::kWigglingSteps;
    steepest = std::max(steepest, std::abs(model.wiggling.slope(phi)));
  }
  return steepest < kSteepestWiggling && model.scale > 0.5 && model.scale < 2;
}

// A model that moves through the search, so that it is made once for all observations.
struct Candidate {
  PmdModel model;
  bool possible = true;
};

// Of one observation, by the unknowns that all pixels share and by its pixel's pattern. The
// candidate holds both already.
class ObservationCost final : public ceres::SizedCostFunction<1, kUnknowns, 1> {
 public:
  ObservationCost(const WallData& data, const FitParts& parts, const Candidate& candidate,
                  const Observation& observation)
      : data_(data), parts_(parts), candidate_(candidate), observation_(observation) {}

  bool Evaluate(double const* const* /*point*/, double* residual,
                double** jacobians) const override {
    if (!candidate_.possible) {
      return false;
    }
    const Row row = row_of(data_, parts_, candidate_.model, observation_);
    residual[0] = row.residual;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      std::ranges::copy(row.by, jacobians[0]);
    }
    if (jacobians != nullptr && jacobians[1] != nullptr) {
      jacobians[1][0] = row.by_pattern;
    }
    return std::isfinite(row.residual);
  }

 private:
  const WallData& data_;
  const FitParts& parts_;
  const Candidate& candidate_;
  const Observation& observation_;
};

class Fit final : public ceres::EvaluationCallback {
 public:
  Fit(const WallData& data, const FitParts& parts, const PmdModel& begin)
      : data_(data),
        parts_(parts),
        seen_(observations(data, begin.phase_falls)),
        emitters_(begin.emitters),
        shared_(unknowns_of(begin)) {
    result_.readings = seen_.size();
    PmdModel& model = candidate_.model;
    model = begin;
    if (parts.pattern || begin.pattern.empty()) {
      model.pattern.resize(data.rays.size(), 0.0);
    }
    pattern_ = model.pattern;
  }

  FitResult run() {
    descend();
    for (int round = 1; round < kPatternRounds && parts_.pattern; ++round) {
      measure_pattern();
      descend();
    }
    centre_pattern();
    result_.model = std::move(candidate_.model);
    return std::move(result_);
  }

  void PrepareForEvaluation(bool /*jacobians*/, bool new_point) override {
    if (new_point) {
      put_unknowns(shared_, emitters_, candidate_.model);
      candidate_.model.pattern = pattern_;
      candidate_.possible = possible(candidate_.model);
    }
  }

 private:
  // What a residual is counted in. It stays while the constants move: a larger sigma must not
  // count as a better fit.
  void weigh() {
    const PmdModel& model = candidate_.model;
    const std::complex<double> stray = model.phase_falls ? std::conj(model.stray) : model.stray;
    for (Observation& o : seen_) {
      const double blur = kModelTurns + kLightAreaM2 / (o.distance_m * model.turn_m);
      const double signal = std::abs(o.iq - o.exposure * stray);
      o.sigma = std::hypot(std::sqrt(o.variance), kTurn * blur * signal);
    }
  }

  // Weak priors decide where walls do not.
  void add_priors(ceres::Problem& problem) {
    ceres::Matrix weights = ceres::Matrix::Zero(kUnknowns, kUnknowns);
    ceres::Vector means = ceres::Vector::Zero(kUnknowns);
    std::vector<int> fixed;
    for (int k = 0; k < kUnknowns; ++k) {
      weights(k, k) = is_active(parts_, k) ? std::sqrt(prior_of(k)) : 0;
      if (!is_active(parts_, k)) {
        fixed.push_back(k);
      }
    }
    means[kScale] = 1;
    problem.AddResidualBlock(new ceres::NormalPrior(weights, means), nullptr, shared_.data());
    if (fixed.size() == kUnknowns) {
      problem.SetParameterBlockConstant(shared_.data());
    } else if (!fixed.empty()) {
      problem.SetManifold(shared_.data(), new ceres::SubsetManifold(kUnknowns, fixed));
    }
  }

  void add_observations(ceres::Problem& problem, ceres::LossFunction& loss) {
    for (const Observation& o : seen_) {
      double* const pattern = &pattern_[o.pixel];
      const bool new_pixel = !problem.HasParameterBlock(pattern);
      problem.AddResidualBlock(new ObservationCost(data_, parts_, candidate_, o), &loss,
                               shared_.data(), pattern);
      if (new_pixel && !parts_.pattern) {
        problem.SetParameterBlockConstant(pattern);
      } else if (new_pixel) {
        problem.AddResidualBlock(
            new ceres::NormalPrior(ceres::Matrix::Constant(1, 1, 1 / pattern_size_),
                                   ceres::Vector::Zero(1)),
            nullptr, pattern);
      }
    }
  }

  // Each pixel's pattern is eliminated before what they share is solved for.
  ceres::Solver::Options solver_options() {
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = kMaxSteps;
    options.function_tolerance = 1e-9;
    options.linear_solver_type = parts_.pattern ? ceres::DENSE_SCHUR : ceres::DENSE_QR;
    if (parts_.pattern) {
      options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
      for (const Observation& o : seen_) {
        options.linear_solver_ordering->AddElementToGroup(&pattern_[o.pixel], 0);
      }
      options.linear_solver_ordering->AddElementToGroup(shared_.data(), 1);
    }
    return options;
  }

  void descend() {
    weigh();
    ceres::Problem::Options ownership;
    ownership.evaluation_callback = this;
    ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::HuberLoss loss(kHuber);
    ceres::Problem problem(ownership);
    add_observations(problem, loss);
    add_priors(problem);
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(), &problem, &summary);
    PrepareForEvaluation(false, true);
    result_.converged = summary.termination_type == ceres::CONVERGENCE;
    result_.cost = summary.final_cost;
    measure_sigmas(problem);
  }

  void measure_sigmas(ceres::Problem& problem) {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    ceres::Covariance covariance(options);
    Square shared = Square::Constant(INFINITY);
    const double* const block = shared_.data();
    if (covariance.Compute(std::vector{block}, &problem)) {
      covariance.GetCovarianceBlock(block, block, shared.data());
    }
    result_.scale_sigma = std::sqrt(shared(kScale, kScale));
    result_.stray_sigma = std::sqrt(std::max(shared(kStrayI, kStrayI), shared(kStrayQ, kStrayQ)));
    result_.wall_turn_sigma =
        std::sqrt(std::max(shared(kWallTurnX, kWallTurnX), shared(kWallTurnY, kWallTurnY)));
    result_.wall_shift_sigma = std::sqrt(shared(kWallShift, kWallShift));
    information_.assign(pattern_.size(), 0);
    for (const Observation& o : seen_) {
      const Row row = row_of(data_, parts_, candidate_.model, o);
      information_[o.pixel] += row.weight * row.by_pattern * row.by_pattern;
    }
  }

  // Of a pixel's pattern.
  double prior() const { return 1 / (pattern_size_ * pattern_size_); }

  // The pattern's own size: its variance less what the readings' noise adds.
  void measure_pattern() {
    double squares = 0;
    double noise = 0;
    double count = 0;
    double sum = 0;
    for (std::size_t p = 0; p < information_.size(); ++p) {
      const double own = information_[p];
      if (!(own > 0)) {
        continue;
      }
      const double free = candidate_.model.pattern[p] * (own + prior()) / own;  // without the prior
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
    std::vector<double>& pattern = candidate_.model.pattern;
    double sum = 0;
    double count = 0;
    for (std::size_t p = 0; p < pattern.size(); ++p) {
      const bool known = information_[p] > prior() / 2;
      sum += known ? pattern[p] : 0;
      count += known ? 1 : 0;
    }
    const double mean = count > 0 ? sum / count : 0;
    for (double& value : pattern) {
      value = value == 0 ? 0 : value - mean;
    }
    candidate_.model.offset = wrapped(candidate_.model.offset + mean);
  }

  const WallData& data_;
  const FitParts parts_;
  std::vector<Observation> seen_;
  const std::vector<dsp::Emitter> emitters_;
  Unknowns shared_;
  std::vector<double> pattern_;
  double pattern_size_ = kWidestPattern;
  std::vector<double> information_;  // of each pixel, what its readings say of its pattern
  Candidate candidate_;
  FitResult result_;
};

}  // namespace

FitResult fit_model(const WallData& data, const FitParts& parts, const PmdModel& begin) {
  return Fit(data, parts, begin).run();
}

}  // namespace stof::host

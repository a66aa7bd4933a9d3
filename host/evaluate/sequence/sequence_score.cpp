#include "host/evaluate/sequence/sequence_score.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "host/evaluate/stereo/median.h"

namespace stof::host {
namespace {

// The values of one pixel in frames of a window.
struct Values {
  double sum = 0;
  double squares = 0;
  double least = INFINITY;
  double most = -INFINITY;
  std::size_t count = 0;

  void add(double value) {
    if (std::isfinite(value)) {
      sum += value;
      squares += value * value;
      least = std::min(least, value);
      most = std::max(most, value);
      ++count;
    }
  }
  double deviation() const {
    const double n = static_cast<double>(count);
    return std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)));
  }
};

bool differs(double truth, double other, double share) {
  return !(std::abs(truth - other) <= share * truth);
}

}  // namespace

void SequenceScorer::add(const DepthPlanes& planes, const dataset::Image<float>& truth) {
  last_.push_back({planes.depth, truth});
  if (last_.size() > kWindowFrames + 1) {
    last_.pop_front();
  }
  const int judged = ++frames_ - warm_up_;
  if (judged <= 0) {
    return;
  }
  scores_.push_back(score_depth(planes, truth));
  count_moving();
  count_leaving();
  if (static_cast<std::size_t>(judged) % kWindowFrames == 0) {
    count_window();
  }
}

void SequenceScorer::count_window() {
  for (std::size_t i = 0; i < last_.back().truth.pixels.size(); ++i) {
    Values truth;
    Values depth;
    for (std::size_t k = last_.size() - kWindowFrames; k < last_.size(); ++k) {
      truth.add(last_[k].truth.pixels[i]);
      depth.add(last_[k].depth.pixels[i]);
    }
    if (truth.count < kWindowFrames || differs(truth.least, truth.most, kStandsStill)) {
      continue;
    }
    flicker_.count(depth.count != 0 && depth.count != kWindowFrames);
    jumps_.count(depth.count != 0 && depth.most - depth.least > kJumpM);
    if (depth.count == kWindowFrames) {
      deviations_.push_back(depth.deviation());
    }
  }
}

void SequenceScorer::count_moving() {
  const Frame& now = last_.back();
  for (std::size_t i = 0; i < now.truth.pixels.size(); ++i) {
    const double truth = now.truth.pixels[i];
    if (std::isfinite(truth) && std::ranges::any_of(last_, [&](const Frame& before) {
          return differs(truth, before.truth.pixels[i], kMoves);
        })) {
      moving_.count(differs(truth, now.depth.pixels[i], kLargestRelativeError));
    }
  }
}

void SequenceScorer::count_leaving() {
  const Frame& now = last_.back();
  for (std::size_t age = 0; age < kLeavingFrames && age + 2 <= last_.size(); ++age) {
    const Frame& left = last_[last_.size() - 1 - age];
    const Frame& before = last_[last_.size() - 2 - age];
    for (std::size_t i = 0; i < now.truth.pixels.size(); ++i) {
      const double behind = left.truth.pixels[i];
      const double surface = before.truth.pixels[i];
      if (std::isfinite(behind) && behind - surface > kLeavesM &&
          !differs(behind, now.truth.pixels[i], kStandsStill)) {
        stays_[age].count(static_cast<double>(now.depth.pixels[i]) < (surface + behind) / 2);
      }
    }
  }
}

SequenceScore SequenceScorer::score() const {
  SequenceScore out{.flicker = flicker_.value(),
                    .jumps = jumps_.value(),
                    .noise_m = median(deviations_),
                    .depth = mean_score(std::span<const DepthScore>(scores_)),
                    .moving_e5 = moving_.value(),
                    .stays = {}};
  for (std::size_t age = 0; age < kLeavingFrames; ++age) {
    out.stays[age] = stays_[age].value();
  }
  return out;
}

}  // namespace stof::host

#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "host/evaluate/fusion/depth_score.h"
#include "host/evaluate/share.h"

namespace stof::host {

inline constexpr std::size_t kWindowFrames = 6;  // in which a depth is steady or not
inline constexpr double kJumpM = 0.5;
inline constexpr double kStandsStill = 0.01;  // the truth changes by less, of itself
inline constexpr double kMoves = 0.05;        // by more
inline constexpr double kLeavesM = 0.5;       // what shows behind is so much farther
inline constexpr std::size_t kLeavingFrames = 3;

// Depth maps of frames that follow each other, against truth. Shares are in 0..1; what has nothing
// to count is absent.
struct SequenceScore {
  // Of pixels whose truth stands still through six frames.
  std::optional<double> flicker;  // have a depth in some of these and none in others
  std::optional<double> jumps;    // two of the depths there are differ by more than kJumpM
  std::optional<double> noise_m;  // median deviation from their mean, of those that have six
  DepthScore depth;               // mean of the frames
  // Of pixels whose truth has moved within the last six frames: E5.
  std::optional<double> moving_e5;
  // Of pixels that a surface has left, in the frame when it left, one later, and two: those whose
  // depth is still nearer to it than to what is behind.
  std::array<std::optional<double>, kLeavingFrames> stays;
};

// Takes frame after frame.
class SequenceScorer {
 public:
  // The first `warm_up` frames are only looked back at.
  explicit SequenceScorer(int warm_up) : warm_up_(warm_up) {}

  // All of one size; truth in metres, +inf = unknown.
  void add(const DepthPlanes& planes, const dataset::Image<float>& truth);
  SequenceScore score() const;

 private:
  struct Frame {
    dataset::Image<float> depth;
    dataset::Image<float> truth;
  };
  void count_window();
  void count_moving();
  void count_leaving();

  int warm_up_;
  int frames_ = 0;
  std::deque<Frame> last_;  // newest last, up to one before the window
  Share flicker_;
  Share jumps_;
  std::vector<double> deviations_;
  std::vector<DepthScore> scores_;
  Share moving_;
  std::array<Share, kLeavingFrames> stays_;
};

}  // namespace stof::host

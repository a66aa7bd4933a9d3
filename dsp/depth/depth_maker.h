#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/base/thread_team.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/drift/drift_monitor.h"
#include "dsp/fusion/fuser.h"
#include "dsp/fusion/guide/guide_maker.h"
#include "dsp/fusion/temporal/past_frames.h"
#include "dsp/fusion/unwrap/unwrapper.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/matcher.h"
#include "dsp/stereo/rectify/rectifier.h"

namespace stof::dsp {

// How pictures and samples become depth.
struct DepthParams {
  MatchParams match;
  FusionParams fusion;    // fusion.trust suits the search: trust_of(match)
  bool guided = false;    // PMD intervals narrow the search (guide_maker.h)
  bool temporal = false;  // frames before count where nothing moves (past_frames.h)

  friend bool operator==(const DepthParams&, const DepthParams&) = default;
};

// The whole way from a pair and PMD samples to a depth map: rectification where the rig asks for
// it, the guide, the search, conversion, unwrapping of readings, fusion. What the appliance runs in
// its loop and what recorded scenes are measured with are both this. Allocates nothing after
// construction. Each frame: convert() where there are new PMD samples, match(), fuse().
class DepthMaker {
 public:
  // calibration is complete(), problem() of it empty; its PMD size may be 0x0: stereo alone.
  // check(params.match) of the stereo size is kOk. The result is the same with any team.
  // searches: as those of a Matcher.
  DepthMaker(const Calibration& calibration, const DepthParams& params, Arena& arena,
             const ThreadTeam& team = {}, SearchMaker* searches = nullptr) noexcept;

  // Samples hold until the next ones; after forget_pmd() there are none.
  void convert(const PmdFrame& frame) noexcept;
  void forget_pmd() noexcept { pmd_ = nullptr; }

  // Pictures of the calibration's size, as the cameras give them. A guide uses the PMD's last data.
  void match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) noexcept;
  // Until the next match() there is no pair: depth comes from the PMD alone, and its samples are
  // not compared with a pair of later.
  void forget_pair() noexcept;

  // After a gap in time: no frame before it counts for the next. The drift that watch()
  // has found stays: what has moved in a rig does not move back.
  void forget_past() noexcept;

  // Writes all images of `out`, of the stereo size, from what is there. Once a frame. pmd_lag_us:
  // from the middle of the pair's exposure to that of the samples, microseconds; where something
  // moves, intervals are longer by it (FusionParams::max_speed_mm_s).
  void fuse(const DepthMap& out, std::int32_t pmd_lag_us = 0) noexcept;

  // Compares both sensors for drift of the rig, where the last frame had a pair and new samples:
  // about 0.3 ms. After fuse() of each frame; costs nothing where there is no PMD. since_us: from
  // the middle of the exposure of the pair before to that of this one, microseconds; 0: not known.
  void watch(std::int32_t since_us = 0) noexcept;
  // What watch() has found so far; about 0.3 ms.
  DriftEstimate drift() const noexcept;

  // On how many frames the last map stands, itself included (PastFrames::frames()); 1 without a
  // pair or DepthParams::temporal, where frames do not count for each other.
  std::uint16_t frames() const noexcept {
    return past_ ? std::max(past_->frames(), std::uint16_t{1}) : std::uint16_t{1};
  }

  // What came of the last frame: empty, or nullptr, without. The pictures are those that were
  // matched: rectified where the rig asks for it.
  StereoMaps stereo() const noexcept;
  const PmdMaps* pmd() const noexcept { return pmd_; }
  ImageView<const std::uint8_t> left() const noexcept { return left_; }
  ImageView<const std::uint8_t> right() const noexcept { return right_; }

 private:
  void look() noexcept;
  void forget_readings() noexcept;

  ThreadTeam team_;
  std::optional<Rectifier> rectifier_;
  std::optional<GuideMaker> guide_maker_;
  Matcher matcher_;
  std::optional<PmdConverter> converter_;
  std::optional<Unwrapper> unwrapper_;
  Fuser fuser_;
  std::optional<PastFrames> past_;
  std::optional<DriftMonitor> monitor_;
  ImageView<Disparity> disparity_;
  ImageView<const std::uint8_t> left_;  // empty: there is no pair
  ImageView<const std::uint8_t> right_;
  const PmdMaps* pmd_ = nullptr;
  bool unresolved_ = false;  // readings whose wrap counts are not known yet
  bool unwatched_ = false;   // samples that watch() has not seen
  std::int32_t pmd_lag_us_ = 0;
};

}  // namespace stof::dsp

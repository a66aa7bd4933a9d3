#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dsp/base/arena.h"
#include "dsp/base/thread_team.h"
#include "dsp/calib/calibration.h"
#include "dsp/depth/depth_maker.h"
#include "firmware/pipeline/shot.h"
#include "firmware/wire/frame/frame_coder.h"
#include "hal/clock.h"

namespace stof::firmware {

// The choices made at start, for good. A PMD lens of 0x0 means stereo alone.
struct Setup {
  dsp::Calibration calibration;
  dsp::DepthParams depth;
  int threads = 1;            // that compute it
  bool require_both = false;  // there is no frame without one of the rig's sensors

  bool has_pmd() const noexcept { return calibration.pmd.lens.width > 0; }
};

// The sizes of this rig's frames.
wire::FrameSizes sizes_of(const Setup& setup) noexcept;

struct Stats {
  hal::Duration match{};  // rectification and the search
  hal::Duration convert{};
  hal::Duration fuse{};                                // and the periods of readings
  hal::Duration watch{};                               // comparing the sensors, of the frame before
  std::array<std::uint32_t, dsp::kSources> sources{};  // pixels of each
  // Likewise, but kInterpolated: that is what the others leave of the picture.
  std::array<std::uint32_t, dsp::kCauses - 1> causes{};

  hal::Duration total() const noexcept { return match + convert + fuse + watch; }
};

struct Output {
  dsp::DepthMap map;
  dsp::StereoMaps stereo;  // of the pair alone
  dsp::ImageView<const std::uint8_t>
      left;  // as it was matched: rectified where the rig asks for it
  dsp::ImageView<const std::uint8_t> right;
  dsp::DriftEstimate drift;  // of the last second
  Stats stats;
  std::uint16_t steady_frames = 1;  // that the map stands on (dsp::DepthMaker::frames())
};

// One shot to one depth map, by the dsp::DepthMaker that evaluation on the host uses too.
class Pipeline {
 public:
  // Builds all tables. setup.calibration is complete(), problem() of it empty; setup.depth.match
  // passes dsp::check. team: of at most setup.threads; no result depends on it.
  Pipeline(const Setup& setup, dsp::Arena& arena, const dsp::ThreadTeam& team = {}) noexcept;

  // Whether match() may come before the PMD's samples: not where they guide the search.
  bool may_match_first() const noexcept { return !guided_; }
  // Rectification and the search, for compute() of the shot that this frame becomes a part of.
  // clock: as for all stages, measures what they take.
  void match(const hal::StereoFrame& stereo, hal::Clock& clock) noexcept;
  // That frame does not become a part of any shot.
  void forget_match() noexcept { matched_ = false; }

  // After a gap in the frames, or with another set of sensors: depth is averaged with none before
  // it.
  void forget_past() noexcept { maker_.forget_past(); }

  // Frames of the calibration's sizes; matches a pair where match() has not. Depth is what the
  // shot's sensors say; without a pair there is no disparity and no picture. The result is valid
  // until the next call of compute() or match().
  const Output& compute(const Shot& shot, hal::Clock& clock) noexcept;
  // Compares the sensors for drift of the rig, after compute(); the next output tells what came of
  // it.
  void watch(hal::Clock& clock) noexcept;

 private:
  dsp::DepthMaker maker_;
  bool guided_;
  bool matched_ = false;
  int until_drift_ = 0;                    // frames
  std::optional<hal::Time> pair_exposed_;  // the last one
  hal::Duration since_pair_{};             // and how long after the one before; 0: there is none
  Output output_;
};

}  // namespace stof::firmware

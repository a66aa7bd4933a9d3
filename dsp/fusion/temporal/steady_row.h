#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/interval/late_intervals.h"

namespace stof::dsp {

// What is remembered of each pixel of a row, 3 bytes. All zero: nothing.
struct SteadyState {
  std::span<QuarterMm> depth;     // what was seen there
  std::span<std::uint8_t> tally;  // bits 0-3 how well it is known, 4-7 votes against it
};

// What both sensors say in this frame, and what was made of it.
struct SteadyRow {
  std::span<const std::uint8_t> changed;  // the picture has changed around it, if one of ..
  std::uint8_t changes = 255;             // .. these bits is set
  IntervalRow stereo;
  IntervalRow pmd;
  FusedRow fused;
  // Fills `stereo` where it is read: its element begin + x is x of these spans. Without it
  // everything is there.
  LateIntervals* late = nullptr;
  std::size_t begin = 0;
};

struct SteadyLimits {
  QuarterMm max_step = 1200;  // further apart is never the same depth
  QuarterMm max_range = 40000;
};

inline constexpr int kTallyBits = 4;
inline constexpr int kMostTally = 15;
inline constexpr int kSeenGain = 2;   // of a frame that agrees; one that does not costs 1
inline constexpr int kSettled = 5;    // the depth stands: three frames have agreed
inline constexpr int kNearVotes = 2;  // a nearer depth counts twice: a robot drives into it
inline constexpr int kVotesToNear = 6;
inline constexpr int kVotesToFar = 3;
inline constexpr int kVotesToFarAgainst = 12;  // where one sensor still confirms what was seen

// One frame of a row. A depth d is published as it is where nothing is known of its pixel, or the
// picture has changed around it: then r = d is remembered. But one of kResolved that appears where
// nothing was known, nor has the picture changed, waits for the next frame: kNone. Else
//   it agrees with r where |d - r| <= min(3/4 width, max_step): published; r becomes the mean of r
//     and the mean of both
//   otherwise, where r is settled and a sensor's own interval comes within min(r / 16, max_step) of
//     r, stereo's first: that interval is published, of kStereo or kPmd, about its depth nearest to
//     r. So a new reading that was doubted counts if it confirms what was seen
//   otherwise no depth is published: kConflict, kContradiction, or what fused has where that has no
//     depth
// A depth that does not agree is a vote against r, two if it is nearer; one that agrees takes one
// back. It is published, and remembered in place of r, where r is not settled, both sensors have an
// interval that excludes r, or there are kVotesToNear of votes for a nearer or kVotesToFar (
// kVotesToFarAgainst where an interval confirms r) for a farther depth.
// Halves round up; intervals are clipped to [1, max_range]. A published interval holds its
// sensor's. Equal lengths, any alignment; no overlap.
using SteadyRowKernel = void(const SteadyRow& row, const SteadyLimits& limits,
                             const SteadyState& state) noexcept;
STOF_KERNEL(SteadyRowKernel, steady_row, kAvx2)

// Lengths as above; max_range at least 1.
void check_steady_row(const SteadyRow& row, const SteadyLimits& limits,
                      const SteadyState& state) noexcept;

}  // namespace stof::dsp

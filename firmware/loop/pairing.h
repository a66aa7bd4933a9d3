#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "board/timing.h"
#include "firmware/events/events.h"
#include "hal/pmd_camera.h"
#include "hal/stereo_camera.h"
#include "hal/time.h"

// Which frame belongs to which trigger edge. Stamps and sequence numbers come from devices and are
// taken for hostile: they are compared, never added or subtracted, until they were found to fit.
namespace stof::firmware {

// A camera that answers at once with frames of other edges is drained by so many a period.
inline constexpr int kMaxFramesPerEdge = 16;

// Exposures that an edge can have caused begin within `tolerance` of it and last `exposure` at
// most, with `tolerance` on top.
struct ExposureWindow {
  hal::Time edge;
  hal::Duration exposure;
  hal::Duration tolerance;
};

// kNone, kOlderEdge, kNewerEdge or kBadStamp.
Drop match_exposure(const ExposureWindow& window, const hal::Exposure& exposure) noexcept;

// Numbers of one sensor, which advance with each exposure. Small steps ahead are believed; after a
// number that does not advance, or leaps, the count is taken up again only when kRestart numbers in
// a row followed each other: a sensor that started anew is back after that many frames, a repeated
// or frozen frame never is.
class SequenceGuard {
 public:
  static constexpr std::uint32_t kMaxStep = 1024;
  static constexpr int kRestart = 8;

  // Whether `sequence` belongs to an exposure that was not accepted before.
  bool advances(std::uint32_t sequence) noexcept;
  void accept(std::uint32_t sequence) noexcept;
  // It is the number that was accepted last: the same exposure once more.
  bool repeats(std::uint32_t sequence) const noexcept { return accepted_ == sequence; }
  // The device was lost: whatever number comes next is new.
  void forget() noexcept { *this = {}; }
  // The device was opened again because it repeated itself: whatever other number comes next.
  void expect_another() noexcept { anew_ = true; }

 private:
  std::optional<std::uint32_t> accepted_;
  std::uint32_t refused_ = 0;
  int run_ = 0;        // refused numbers that followed each other, up to refused_
  bool anew_ = false;  // any other number than accepted_ is new
};

// Cameras of the pair, as a sum; the value of condition `stereo frozen`.
enum Eyes : std::uint8_t { kNoEye = 0, kLeftEye = 1, kRightEye = 2 };

constexpr Eyes eyes(bool left, bool right) noexcept {
  return static_cast<Eyes>((left ? kLeftEye : kNoEye) | (right ? kRightEye : kNoEye));
}

// Judges stereo frames: size, sequences, both exposures.
class StereoPairing {
 public:
  StereoPairing(int width, int height) noexcept : width_(width), height_(height) {}
  // kNone: the frame is of this edge, and new. Remembers its numbers then.
  Drop judge(const ExposureWindow& window, const hal::StereoFrame& frame) noexcept;
  // The eyes whose exposure was accepted before.
  Eyes repeating(const hal::StereoFrame& frame) const noexcept {
    return eyes(left_.repeats(frame.left_sequence), right_.repeats(frame.right_sequence));
  }
  void forget() noexcept;
  void expect_another() noexcept;  // of both eyes

 private:
  int width_;
  int height_;
  SequenceGuard left_;
  SequenceGuard right_;
};

// The verdict on a PMD frame: with kNone it belongs to the `age`-th of the windows.
struct PmdVerdict {
  Drop drop = Drop::kNone;
  int age = 0;
};

// Judges PMD frames: the first sample begins at the edge, all four follow each other and end within
// the integration time.
class PmdPairing {
 public:
  PmdPairing(int width, int height) noexcept : width_(width), height_(height) {}
  // windows: the edges that may have caused it, the newest first; at least one.
  PmdVerdict judge(std::span<const ExposureWindow> windows, const hal::PmdFrame& frame) noexcept;
  // Its exposures were accepted before.
  bool repeating(const hal::PmdFrame& frame) const noexcept {
    return sequence_.repeats(frame.sequence);
  }
  void forget() noexcept { sequence_.forget(); }
  void expect_another() noexcept { sequence_.expect_another(); }

 private:
  int width_;
  int height_;
  SequenceGuard sequence_;
};

}  // namespace stof::firmware

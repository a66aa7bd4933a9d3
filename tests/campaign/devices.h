#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/clock.h"
#include "hal/emu/cameras/pmd_camera.h"
#include "hal/emu/cameras/stereo_camera.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/devices/faults.h"
#include "tests/campaign/wall.h"
#include "tests/support/random.h"

// The emulated devices of a campaign: those of hal/emu with their FaultPlan, and around them faults
// that begin and end at any moment, in mid-exposure and mid-readout too, and devices that lie.
namespace stof::campaign {

// Of the rig's edges.
inline constexpr hal::Duration kPeriod = std::chrono::milliseconds(33);

struct Span {
  hal::Time begin = hal::Time::max();
  hal::Time end = hal::Time::max();

  bool holds(hal::Time at) const noexcept { return begin <= at && at < end; }
  bool meets(hal::Time from, hal::Time to) const noexcept { return from < end && begin < to; }
};

// What a device says that is not so. Its pixels or stamps are not those of its exposure.
enum class Lie : std::uint8_t {
  kNone,
  kOldPixels,        // of the edge before the fault, under new stamps: of the pair's right view
  kOldPixelsOfBoth,  // of both views
  kDark,             // PMD: samples without light
  kLaterStamps,      // stamps of the next edge
  kEarlierStamps,    // stamps of the edge before
  kNoStamps,         // 0
  kEndsBeforeItBegins,
  kSequenceStands,  // the sequence number is that of the frame before
};

// One fault of a device; `kind` and `lie` exclude each other.
struct TimedFault {
  emu::FaultKind kind = emu::FaultKind::kNone;
  Lie lie = Lie::kNone;
  Span span{};
  hal::Duration duration{};  // of kDelay; of kRepeat on the trigger; a trigger's lie about its time
};

// Time that moves when somebody waits, when the program is stopped, and, where the processor is
// busy, whenever somebody looks.
class Clock final : public hal::Clock {
 public:
  hal::Time now() noexcept override;
  void wait_until(hal::Time time) noexcept override;
  // Without effect on the time.
  hal::Time peek() const noexcept { return now_; }

  void stop(const Span& span) noexcept { stop_ = span; }
  // Every look takes up to `most`.
  void busy(const Span& span, hal::Duration most) noexcept {
    busy_ = span;
    most_ = most;
  }

 private:
  void strike() noexcept;

  hal::Time now_{std::chrono::seconds(1000)};
  Span stop_{};
  Span busy_{};
  hal::Duration most_{};
  test::Random random_{7};
};

class StereoCamera final : public hal::StereoCamera {
 public:
  StereoCamera(hal::StereoCamera& camera, Clock& clock, const EdgeLog& log, const RigSize& size)
      : camera_(camera), clock_(clock), log_(log), size_(size) {}
  Result<hal::BorrowedFrame<hal::StereoFrame>> wait_frame(hal::Time deadline) noexcept override;

  TimedFault fault{};

 private:
  void paint(hal::StereoFrame& frame, bool struck) noexcept;
  void lie(hal::StereoFrame& frame) noexcept;

  hal::StereoCamera& camera_;
  Clock& clock_;
  const EdgeLog& log_;
  RigSize size_;
  std::optional<hal::StereoFrame> before_{};  // its stamps alone count
  std::size_t edge_before_ = 0;
};

class PmdCamera final : public hal::PmdCamera {
 public:
  PmdCamera(hal::PmdCamera& camera, Clock& clock, const EdgeLog& log, const RigSize& size,
            hal::Duration integration)
      : camera_(camera),
        clock_(clock),
        log_(log),
        size_(size),
        lens_(setup_of(size).calibration.pmd.lens),
        integration_(integration) {}
  Result<hal::BorrowedFrame<hal::PmdFrame>> wait_frame(hal::Time deadline) noexcept override;

  TimedFault fault{};

 private:
  void paint(hal::PmdFrame& frame, bool struck) noexcept;
  void lie(hal::PmdFrame& frame) noexcept;

  hal::PmdCamera& camera_;
  Clock& clock_;
  const EdgeLog& log_;
  RigSize size_;
  dsp::Pinhole lens_;
  hal::Duration integration_;
  std::optional<hal::PmdFrame> before_{};
  std::size_t edge_before_ = 0;
};

// Lets edges through to the cameras, or not.
class Gate final : public emu::EdgeListener {
 public:
  Gate(EdgeLog& log, emu::StereoCamera& stereo, emu::PmdCamera& pmd)
      : log_(log), stereo_(stereo), pmd_(pmd) {}
  void on_edge(hal::Time edge) noexcept override {
    if (!shut) {
      log_.on_edge(edge);
      stereo_.on_edge(edge);
      pmd_.on_edge(edge);
    }
  }
  bool shut = false;

 private:
  EdgeLog& log_;
  emu::StereoCamera& stereo_;
  emu::PmdCamera& pmd_;
};

class Trigger final : public hal::Trigger {
 public:
  Trigger(hal::Trigger& trigger, Clock& clock, Gate& gate)
      : trigger_(trigger), clock_(clock), gate_(gate) {}
  Result<hal::Time> pulse() noexcept override;

  // kTear and kCorrupt: no edge, kDeviceError. A lie: the time returned is `duration` off.
  TimedFault fault{};

  // When pulse() was called for the call-th time; of the first calls.
  std::optional<hal::Time> time_of_call(std::uint32_t call) const noexcept {
    return call < call_times_.size() ? std::optional(call_times_[call]) : std::nullopt;
  }

 private:
  static constexpr std::size_t kTimedCalls = 4096;

  hal::Trigger& trigger_;
  Clock& clock_;
  Gate& gate_;
  std::vector<hal::Time> call_times_;
};

}  // namespace stof::campaign

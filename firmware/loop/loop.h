#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "board/board.h"
#include "board/timing.h"
#include "dsp/base/status.h"
#include "firmware/events/events.h"
#include "firmware/loop/device_lending.h"
#include "firmware/loop/frame_collector.h"
#include "firmware/loop/loop_conditions.h"
#include "firmware/loop/schedule.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/publisher.h"
#include "firmware/pipeline/shot.h"

namespace stof::firmware {

// The one loop. Where a frame can be computed before the next edge, it pulses the trigger for n,
// searches while the PMD camera still integrates, collects, fuses and publishes n: the last packet
// leaves before the next edge. Where the computer is too slow for that, it pulses for n + 1,
// computes and publishes n, and collects n + 1: a period later, at the same rate. So does a frame
// that had to wait until the next edge for a sensor which then gave nothing: no edge comes late for
// it. Allocates nothing.
class Loop {
 public:
  // board::problem(timing) must be empty; pipeline was built for frames of the setup's sizes.
  // lending: devices that are lost, and cameras that repeat themselves, are lent, to be opened
  // again; nullptr: they come back by themselves.
  Loop(board::Board& board, const board::TimingConfig& timing, const Setup& setup,
       Pipeline& pipeline, Publisher& publisher, Events& events,
       DeviceLending* lending = nullptr) noexcept;

  // Waits for the next edge, but no longer than kWaitPart: whoever runs the loop can look after
  // other things meanwhile. True: the edge is near, it is step()'s turn; without waiting where it
  // was near from the start.
  bool wait_part() noexcept;
  static constexpr hal::Duration kWaitPart = std::chrono::milliseconds(20);

  // One period. Blocks until the next point of the grid, and there computes and publishes.
  // kOk: whether or not there was a frame. kDeviceLost: a device is lost.
  Status step() noexcept;

  // Standby: in place of wait_part() and step(), again and again. Waits for kWaitPart; no edge goes
  // out. What was not published is left out, and nothing of before counts for the next frame.
  void rest_part() noexcept;
  // A device is lost or repeats itself: only edges tell when it is well again.
  bool has_trouble() const noexcept;
  // After rest_part(): the next edge is due at once, or a period after the last one.
  void wake() noexcept;

  // No frame is published beyond so many since the start; 0: there is no end.
  void end_after(std::uint64_t frames) noexcept { most_frames_ = frames; }

  // From now on there is no frame without one of the rig's sensors, or there is.
  void require_both(bool both) noexcept { collector_.require_both(both); }

  // From now on cameras are judged by the setup's calibration; of the same sizes. Then restart().
  void recalibrate(const Setup& setup) noexcept { collector_.recalibrate(setup); }

  // The pipeline was built anew: it remembers no frame, and no samples.
  void note_begun_anew() noexcept;

  // After a pause, with another timing perhaps; board::problem(timing) must be empty.
  void restart(const board::TimingConfig& timing) noexcept;

 private:
  Status run_period() noexcept;
  void lend_devices() noexcept;
  void follow_replay() noexcept;
  void wait_for_edge() noexcept;
  Result<hal::Time> pulse() noexcept;
  // A shot that was collected before this period.
  Status publish_waiting() noexcept;
  // latest: when its last packet leaves. usual: its delay is what frames like it take.
  Status publish_held(hal::Time latest, bool usual) noexcept;
  // Of all sensors of this rig.
  bool is_whole(const Shot& shot) const noexcept;
  // Tells the pipeline where this shot does not follow the one that was computed before it, or has
  // other sensors than that; and the shot what it is computed with.
  void note_gap(Shot& shot) noexcept;
  // By what this frame has cost.
  void update_schedule(const Stats& stats, hal::Time edge) noexcept;
  Status collect(hal::Time edge) noexcept;

  board::Board& board_;
  Pipeline& pipeline_;
  Publisher& publisher_;
  DeviceLending* lending_;
  LoopConditions conditions_;
  Schedule schedule_;
  FrameCollector collector_;
  std::optional<Shot> held_;
  std::optional<hal::Time> last_edge_;  // of the shot that was computed last; none: a gap follows
  std::uint64_t stereo_losses_ = 0;     // of the camera, up to that shot
  Sensors sensors_ = kBothSensors;      // of that shot
  std::uint64_t most_frames_ = 0;
  bool begun_anew_ = true;  // since that shot
};

}  // namespace stof::firmware

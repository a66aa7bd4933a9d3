#pragma once

#include <array>
#include <cstdint>

#include "dsp/base/status.h"
#include "firmware/events/events.h"
#include "firmware/events/health_monitor.h"
#include "firmware/loop/schedule.h"
#include "firmware/pipeline/shot.h"
#include "hal/clock.h"

namespace stof::firmware {

// Why an edge has nothing of a camera that is there.
struct Absence {
  enum class Why : std::uint8_t { kNone, kSilent, kFrozen, kDark };  // kNone: it has

  Why why = Why::kNone;
  std::uint32_t value = 0;  // of the condition
};

// The conditions of the devices and of the loop itself. Each answer of a device is counted; where a
// condition begins or ends, one event is noted, for the log and for the health monitor.
class LoopConditions {
 public:
  LoopConditions(hal::Clock& clock, Events& events, HealthMonitor& monitor) noexcept
      : clock_(clock), events_(events), monitor_(monitor) {}

  // Takes a device's answer: kOk, or an error, of which kDeviceLost lasts until another answer.
  void note_device_status(Component component, Status status) noexcept;
  // Takes what an edge has of a camera. Several edges in a row without anything are a condition;
  // that of a lost camera is its loss.
  void note_camera(Component camera, const Absence& absence) noexcept;
  // Takes the link's answer to a frame. A full link (kWouldBlock) is no error here: the publisher
  // counts its drops.
  void note_link_status(Status status) noexcept;
  // How late the loop was for an edge, at `now`.
  void note_lateness(const Schedule::Lateness& lateness, hal::Time now) noexcept;
  // An edge that has a frame, of these sensors.
  void note_frame(Sensors sensors) noexcept;
  // One that has none: which component was missing, and what it said last.
  void note_no_frame(Component missing, Status why) noexcept;

  bool lost(Component component) const noexcept {
    return lost_[static_cast<std::size_t>(component)];
  }
  // It was told that the camera repeats itself, and it still did at the last edge.
  bool repeats(Component camera) const noexcept {
    const Supply& supply = supplies_[static_cast<std::size_t>(camera)];
    return supply.told == Absence::Why::kFrozen && supply.last == Absence::Why::kFrozen;
  }
  // Since the last edge that had a frame.
  std::uint32_t edges_without_frame() const noexcept { return edges_without_frame_; }

  Counters& counters() noexcept { return events_.counters; }

 private:
  // So many edges in a row without a frame, or a camera's, are a condition; fewer are only counted.
  static constexpr std::uint32_t kSilentEdges = 3;
  // The loop is in time again after so many edges in time.
  static constexpr std::uint32_t kInTimeEdges = 32;
  // One period that is skipped within so many edges of the start is only counted: the first frames
  // bring memory and tables into the caches.
  static constexpr std::uint32_t kFirstEdges = 32;

  // What was told of a camera, why the last edge has nothing of it, and the edges in a row without
  // anything.
  struct Supply {
    Absence::Why told = Absence::Why::kNone;
    Absence::Why last = Absence::Why::kNone;
    std::uint32_t edges = 0;
  };

  void note(const Event& event) noexcept;

  hal::Clock& clock_;
  Events& events_;
  HealthMonitor& monitor_;
  std::array<bool, kComponents> lost_{};
  std::array<Supply, kComponents> supplies_{};  // of cameras
  bool unreachable_ = false;                    // no receiver
  bool publishing_ = false;
  Sensors told_sensors_ = kNoSensor;  // that frames stand on
  Sensors sensors_ = kNoSensor;       // of the last frame
  std::uint32_t alike_ = 0;           // frames in a row with these sensors
  std::uint32_t edges_without_frame_ = 0;
  std::uint32_t edges_in_time_ = kInTimeEdges;  // since the loop was late, up to kInTimeEdges
  std::uint32_t first_edges_ = kFirstEdges;     // to go
};

}  // namespace stof::firmware

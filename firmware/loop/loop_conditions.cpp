#include "firmware/loop/loop_conditions.h"

#include <utility>

namespace stof::firmware {
namespace {

EventKind event_of(Absence::Why why) noexcept {
  switch (why) {
    case Absence::Why::kFrozen:
      return EventKind::kFrozen;
    case Absence::Why::kDark:
      return EventKind::kDark;
    case Absence::Why::kSilent:
      return EventKind::kSilent;
    case Absence::Why::kNone:
      break;
  }
  return EventKind::kSupplying;
}

}  // namespace

void LoopConditions::note(const Event& event) noexcept {
  events_.note(event);
  monitor_.observe(event);
}

void LoopConditions::note_device_status(Component component, Status status) noexcept {
  Counters& counters = events_.counters;
  const bool lost = status == Status::kDeviceLost;
  if (lost != std::exchange(lost_[static_cast<std::size_t>(component)], lost)) {
    note({clock_.now(), lost ? EventKind::kLost : EventKind::kBack, component, status, 0});
  }
  if (lost) {
    ++of(counters.losses, component);
  } else if (status == Status::kTimeout) {
    ++of(counters.timeouts, component);
  } else if (status != Status::kOk) {
    ++of(counters.errors, component);
  }
}

void LoopConditions::note_camera(Component camera, const Absence& absence) noexcept {
  Supply& supply = supplies_[static_cast<std::size_t>(camera)];
  if (lost(camera)) {
    supply = {};
    return;
  }
  supply.last = absence.why;
  supply.edges = absence.why == Absence::Why::kNone ? 0 : supply.edges + 1;
  const bool news = supply.edges == 0 || supply.edges >= kSilentEdges;
  if (news && std::exchange(supply.told, absence.why) != absence.why) {
    note({clock_.now(), event_of(absence.why), camera, Status::kOk, absence.value});
  }
}

void LoopConditions::note_link_status(Status status) noexcept {
  note_device_status(Component::kLink, status == Status::kWouldBlock ? Status::kOk : status);
  const bool unreachable = status == Status::kDeviceError;
  if (unreachable != std::exchange(unreachable_, unreachable)) {
    note({clock_.now(), unreachable ? EventKind::kSendFailed : EventKind::kSending,
          Component::kLink, status, 0});
  }
}

void LoopConditions::note_lateness(const Schedule::Lateness& lateness, hal::Time now) noexcept {
  Counters& counters = events_.counters;
  counters.skipped_periods += lateness.skipped;
  counters.late_edges += lateness.noticeable ? 1U : 0U;
  if (first_edges_ > 0) {
    --first_edges_;
    if (lateness.skipped == 1) {
      first_edges_ = 0;  // the next one is told
      return;
    }
  }
  if (lateness.skipped > 0) {
    if (std::exchange(edges_in_time_, 0) >= kInTimeEdges) {
      note({now, EventKind::kLate, Component::kLoop, Status::kTimeout,
            static_cast<std::uint32_t>(lateness.skipped)});
    }
  } else if (edges_in_time_ < kInTimeEdges && ++edges_in_time_ == kInTimeEdges) {
    note({now, EventKind::kInTime, Component::kLoop, Status::kOk, 0});
  }
}

void LoopConditions::note_frame(Sensors sensors) noexcept {
  if (!std::exchange(publishing_, true)) {
    note({clock_.now(), EventKind::kPublishing, Component::kLoop, Status::kOk,
          edges_without_frame_});
  }
  edges_without_frame_ = 0;
  alike_ = std::exchange(sensors_, sensors) == sensors ? alike_ + 1 : 1;
  // Those at the start are no news: a line at the start, or a lost camera's, tells them.
  if (alike_ >= kSilentEdges) {
    const Sensors before = std::exchange(told_sensors_, sensors);
    if (before != kNoSensor && before != sensors) {
      note({clock_.now(), EventKind::kStandsOn, Component::kLoop, Status::kOk, sensors});
    }
  }
}

void LoopConditions::note_no_frame(Component missing, Status why) noexcept {
  ++events_.counters.unpaired_edges;
  if (++edges_without_frame_ == kSilentEdges) {
    publishing_ = false;
    note({clock_.now(), EventKind::kUnpaired, missing, why, edges_without_frame_});
  }
}

}  // namespace stof::firmware

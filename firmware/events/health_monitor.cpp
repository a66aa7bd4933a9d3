#include "firmware/events/health_monitor.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace stof::firmware {
namespace {

constexpr hal::Duration kSecond = std::chrono::seconds(1);
constexpr hal::Duration kChangeLasts = std::chrono::seconds(10);
constexpr std::uint64_t kFlood = 1000;  // refused requests in a second

constexpr std::size_t index_of(wire::Condition condition) noexcept {
  return static_cast<std::size_t>(condition);
}

std::uint64_t refused(const wire::ControlCounters& requests) noexcept {
  return requests.truncated + requests.bad_magic + requests.bad_version + requests.bad_length +
         requests.bad_crc + requests.bad_field + requests.not_control + requests.foreign +
         requests.too_short + requests.busy + requests.overrun + requests.forged +
         requests.replayed;
}

std::uint32_t less(std::uint64_t now, std::uint64_t before) noexcept {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(now - before, 0xFFFF'FFFF));
}

std::optional<wire::Condition> lost(Component component) noexcept {
  switch (component) {
    case Component::kTrigger:
      return wire::Condition::kTriggerLost;
    case Component::kStereo:
      return wire::Condition::kStereoLost;
    case Component::kPmd:
      return wire::Condition::kPmdLost;
    case Component::kLink:
      return wire::Condition::kLinkLost;
    case Component::kLoop:
      break;
  }
  return std::nullopt;
}

// Of pixels: a share that is a condition. It must be twice as large to end it.
bool hardly_any(std::uint64_t some, std::uint64_t all, bool before) noexcept {
  constexpr std::uint64_t kLeastPercent = 2;
  return some * 100 < all * kLeastPercent * (before ? 2 : 1);
}

// What may be wrong with a camera that is there.
struct SupplyCondition {
  Component camera;
  EventKind begins;
  wire::Condition condition;
};
constexpr std::array<SupplyCondition, 5> kSupplyConditions{{
    {Component::kStereo, EventKind::kSilent, wire::Condition::kStereoSilent},
    {Component::kStereo, EventKind::kFrozen, wire::Condition::kStereoFrozen},
    {Component::kPmd, EventKind::kSilent, wire::Condition::kPmdSilent},
    {Component::kPmd, EventKind::kFrozen, wire::Condition::kPmdFrozen},
    {Component::kPmd, EventKind::kDark, wire::Condition::kPmdDark},
}};

}  // namespace

std::uint32_t microseconds(hal::Duration time) noexcept {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(time).count();
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(us, 0, 0xFFFF'FFFF));
}

void HealthMonitor::observe(const Event& event) noexcept {
  switch (event.kind) {
    case EventKind::kPublishing:
    case EventKind::kUnpaired:
      set(wire::Condition::kNoFrames, event.kind == EventKind::kUnpaired, event.value, event.at);
      break;
    case EventKind::kLost:
    case EventKind::kBack:
      if (const std::optional<wire::Condition> which = lost(event.component)) {
        set(*which, event.kind == EventKind::kLost, 0, event.at);
      }
      observe_supply(event);
      break;
    case EventKind::kSilent:
    case EventKind::kFrozen:
    case EventKind::kDark:
    case EventKind::kSupplying:
      observe_supply(event);
      break;
    case EventKind::kSettingsChanged:
      begin(wire::Condition::kSettingsChanged, event.value, event.at);
      entries_[index_of(wire::Condition::kSettingsChanged)].former = event.former;
      break;
    case EventKind::kKeyMade:
    case EventKind::kKeyRenewed:
    case EventKind::kKeyEnded:
    case EventKind::kLastKeyEnded:
      begin(wire::Condition::kKeysChanged, event.value, event.at);
      break;
    case EventKind::kCalibrationChanged:
      // Before it is told: begin() may keep the last one's report.
      begin(wire::Condition::kCalibrationChanged, event.value, event.at);
      entries_[index_of(wire::Condition::kCalibrationChanged)].former = event.former;
      break;
    case EventKind::kRelease:
      observe_release(event);
      break;
    case EventKind::kPairing:
      if (event.former == kPairingHeldInVain) {
        break;  // all is as it was
      }
      if (event.value == kPairingClosed || event.value == kPairingDone) {
        set(wire::Condition::kPairing, false, 0, event.at);
      } else {
        begin(wire::Condition::kPairing, event.value == kPairingOpen ? 0 : event.value, event.at);
      }
      break;
    case EventKind::kStandsOn:  // what is missing is a condition of its own
    case EventKind::kStandby:   // asked for, and nobody receives
      break;
    case EventKind::kSendFailed:
    case EventKind::kSending:
      set(wire::Condition::kUnreachable, event.kind == EventKind::kSendFailed, 0, event.at);
      break;
    case EventKind::kLate:
    case EventKind::kInTime:
      set(wire::Condition::kLate, event.kind == EventKind::kLate, event.value, event.at);
      break;
  }
}

// It ends with a value, and where the start before began it, it ends without having begun.
void HealthMonitor::observe_release(const Event& event) noexcept {
  Entry& entry = entries_[index_of(wire::Condition::kReleaseOnTrial)];
  change(entry, event.value == kReleaseOnTrial, event.value, event.at);
  entry.former = event.former;
}

void HealthMonitor::tell_release_again() noexcept {
  Entry& entry = entries_[index_of(wire::Condition::kReleaseOnTrial)];
  entry.again = entry.again || (entry.value != kNoRelease && !entry.changed);
}

void HealthMonitor::observe_supply(const Event& event) noexcept {
  for (const SupplyCondition& possible : kSupplyConditions) {
    if (possible.camera == event.component) {
      set(possible.condition, possible.begins == event.kind, event.value, event.at);
    }
  }
}

void HealthMonitor::set(wire::Condition condition, bool active, std::uint32_t value,
                        hal::Time now) noexcept {
  Entry& entry = entries_[index_of(condition)];
  if (entry.active != active) {
    change(entry, active, value, now);
  }
}

void HealthMonitor::begin(wire::Condition condition, std::uint32_t value, hal::Time now) noexcept {
  change(entries_[index_of(condition)], true, value, now);
}

void HealthMonitor::change(Entry& entry, bool active, std::uint32_t value, hal::Time now) noexcept {
  if (entry.changed) {
    static_cast<void>(earlier_.push(report(static_cast<std::size_t>(&entry - entries_.data()))));
  }
  entry.active = active;
  entry.value = value;
  entry.at = now;
  entry.count += active ? 1U : 0U;
  sequence_ = sequence_ == ~0U ? 1 : sequence_ + 1;
  entry.sequence = sequence_;
  entry.changed = true;
  entry.again = false;
  changed_ = true;
}

void HealthMonitor::note_blinding(std::uint32_t by_settings, hal::Time now) noexcept {
  set_blindness((blindness_ & kNoCoverage) | by_settings, now);
}

void HealthMonitor::set_blindness(std::uint32_t blindness, hal::Time now) noexcept {
  if (std::exchange(blindness_, blindness) == blindness) {
    return;
  }
  if (blindness == 0) {
    set(wire::Condition::kNoDepth, false, 0, now);
  } else {
    begin(wire::Condition::kNoDepth, blindness, now);
  }
}

void HealthMonitor::judge_coverage(hal::Time now) noexcept {
  if (sums_.pixels == 0) {
    return;  // without frames there is another condition
  }
  const bool blind = (blindness_ & kNoCoverage) != 0;
  if (hardly_any(sums_.with_depth, sums_.pixels, blind) != blind) {
    set_blindness(blindness_ ^ kNoCoverage, now);
  }
}

// Without frames, and without the pair, there are other conditions.
void HealthMonitor::judge_matches(hal::Time now) noexcept {
  if (sums_.pixels == 0) {
    return;
  }
  const bool blind = entries_[index_of(wire::Condition::kStereoBlind)].active;
  set(wire::Condition::kStereoBlind,
      sums_.of_pair > 0 && hardly_any(sums_.matched, sums_.of_pair, blind), 0, now);
}

void HealthMonitor::frame_sent(hal::Duration latency, bool drifted, std::uint32_t drifts,
                               hal::Time now) noexcept {
  ++sums_.frames;
  sums_.latency += latency;
  sums_.longest = std::max(sums_.longest, latency);
  set(wire::Condition::kDrift, drifted, drifts, now);
}

wire::Health HealthMonitor::summary() const noexcept {
  wire::Health health = wire::Health::kOk;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (!entries_[i].active) {
      continue;
    }
    const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(i));
    if (info->severity == wire::Severity::kCritical) {
      return wire::Health::kFault;
    }
    if (info->severity != wire::Severity::kInfo) {
      health = wire::Health::kDegraded;
    }
  }
  return health;
}

wire::EventReport HealthMonitor::report(std::size_t condition) const noexcept {
  const Entry& entry = entries_[condition];
  const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(condition));
  return {.sequence = entry.sequence,
          .condition = static_cast<std::uint8_t>(condition),
          .severity = info->severity,
          .reaction = info->reaction,
          .active = static_cast<std::uint8_t>(entry.active ? 1 : 0),
          .count = entry.count,
          .value = entry.value,
          .at_ns = entry.at.time_since_epoch().count(),
          .former = entry.former};
}

std::optional<wire::EventReport> HealthMonitor::next_event(hal::Time now) noexcept {
  if (std::optional<wire::EventReport> earlier = earlier_.pop()) {
    return earlier;
  }
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    Entry& entry = entries_[i];
    if (std::exchange(entry.changed, false)) {
      entry.again = true;
      return report(i);
    }
    if (entry.again && now - entry.at >= kSecond) {
      entry.again = false;
      return report(i);
    }
  }
  return std::nullopt;
}

// Ends a condition that lasts for a while after each change.
void HealthMonitor::set_recent(wire::Condition condition, hal::Time now) noexcept {
  if (now - entries_[index_of(condition)].at >= kChangeLasts) {
    set(condition, false, 0, now);
  }
}

// What only a whole second can tell.
void HealthMonitor::judge_second(const Counters& counters, const ControlStatus& control,
                                 hal::Time now) noexcept {
  const std::int64_t passed = (now - sums_.begin).count();
  rate_millihertz_ =
      static_cast<std::uint32_t>(std::int64_t{sums_.frames} * 1'000'000'000'000 / passed);
  latency_us_ = sums_.frames == 0 ? 0 : microseconds(sums_.latency / sums_.frames);
  longest_us_ = microseconds(sums_.longest);
  const std::uint32_t dropped = less(counters.packets_dropped, sums_.dropped);
  const std::uint32_t serial = less(control.serial_dropped, sums_.serial_dropped);
  const std::uint32_t flood = less(refused(control.requests), sums_.refused);
  // Whoever cannot be reached at all is another matter.
  const bool full = dropped > 0 && !entries_[index_of(wire::Condition::kUnreachable)].active &&
                    !entries_[index_of(wire::Condition::kLinkLost)].active;
  set(wire::Condition::kLinkFull, full, dropped, now);
  set(wire::Condition::kSerialFull, serial > 0, serial, now);
  set(wire::Condition::kFlooded, flood > kFlood, flood, now);
  judge_coverage(now);
  judge_matches(now);
  sums_ = {.begin = now,
           .dropped = counters.packets_dropped,
           .serial_dropped = control.serial_dropped,
           .refused = refused(control.requests)};
}

std::optional<wire::HealthReport> HealthMonitor::next_health(const Counters& counters,
                                                             const ControlStatus& control,
                                                             bool wanted, hal::Time now) noexcept {
  set(wire::Condition::kSerialLost, control.serial_lost, 0, now);
  set(wire::Condition::kSettingsUnsaved, control.settings_unsaved, 0, now);
  set(wire::Condition::kSettingsFellBack, control.settings_fell_back, 0, now);
  set(wire::Condition::kRestartNeeded, control.restart_needed, 0, now);
  set(wire::Condition::kSettingsDropped, control.settings_dropped != 0, control.settings_dropped,
      now);
  set(wire::Condition::kConnectionReplaced, control.connection_replaced != 0,
      control.connection_replaced, now);
  set(wire::Condition::kCalibrationDropped, control.calibration_dropped != 0,
      control.calibration_dropped, now);
  set(wire::Condition::kUnpaired, control.unpaired, 0, now);
  set(wire::Condition::kKeysLost, control.keys_lost, 0, now);
  set_recent(wire::Condition::kSettingsChanged, now);
  set_recent(wire::Condition::kKeysChanged, now);
  set_recent(wire::Condition::kCalibrationChanged, now);
  const bool second = now - sums_.begin >= kSecond;
  if (second) {
    judge_second(counters, control, now);
  }
  if (!second && !changed_ && !wanted) {
    return std::nullopt;
  }
  changed_ = false;
  wire::HealthReport health{
      .uptime_ms = static_cast<std::uint64_t>((now - start_) / std::chrono::milliseconds(1)),
      .subscribers = control.subscribers,
      .rate_millihertz = rate_millihertz_,
      .latency_us = latency_us_,
      .longest_latency_us = longest_us_,
      .settings_revision = control.settings_revision,
      .counters = loop_counters(counters),
      .packets_sent = counters.packets_sent,
      .control = control.requests,
      .serial_sent = control.serial_sent,
      .serial_dropped = control.serial_dropped,
      .serial_refused = control.serial_refused,
      .events = sequence_};
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].active) {
      const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(i));
      health.active |= 1U << i;
      health.severity = std::max(health.severity, info->severity);
      health.reaction = std::max(health.reaction, info->reaction);
    }
  }
  return health;
}

wire::LoopCounters loop_counters(const Counters& counters) noexcept {
  std::uint64_t mispaired = 0;
  for (std::size_t cause = 0; cause < kDrops; ++cause) {
    if (cause != static_cast<std::size_t>(Drop::kUnpartnered) &&
        cause != static_cast<std::size_t>(Drop::kDark)) {
      mispaired += counters.stereo_dropped[cause] + counters.pmd_dropped[cause];
    }
  }
  return {.edges = counters.edges,
          .frames_published = counters.published,
          .mispaired = mispaired,
          .timeouts =
              of(counters.timeouts, Component::kStereo) + of(counters.timeouts, Component::kPmd),
          .deadline_misses = counters.skipped_periods + counters.expired,
          .link_drops = counters.packets_dropped};
}

}  // namespace stof::firmware

#include "host/client/session/link_watch.h"

#include <algorithm>

namespace stof::client {
namespace {

constexpr Duration kUnknownSilence = std::chrono::milliseconds(500);
constexpr Duration kSilenceBeyondPeriods = std::chrono::milliseconds(20);

std::optional<Duration> age(const std::optional<Time>& at, Time now) noexcept {
  return at ? std::optional(std::max(now - *at, Duration(0))) : std::nullopt;
}

}  // namespace

Duration silence_after(Duration period) noexcept {
  return period > Duration(0) ? 3 * period + kSilenceBeyondPeriods : kUnknownSilence;
}

void LinkWatch::look(const Reassembler& reassembler, Time now) noexcept {
  const Statistics& statistics = reassembler.statistics();
  const SessionMessages& messages = reassembler.messages();
  if (statistics.sessions > std::max<std::uint64_t>(sessions_, 1)) {
    restarted_at_ = now;
  }
  sessions_ = statistics.sessions;
  const std::uint64_t forgeries = statistics.implausible + reassembler.forgeries();
  if (forgeries > forgeries_) {
    forged_at_ = now;
  }
  forgeries_ = forgeries;
  if (reassembler.late_frames() > late_) {
    late_at_ = now;
  }
  late_ = reassembler.late_frames();
  health_at_ = messages.health() ? std::optional(messages.health_at()) : std::nullopt;
  calibration_at_ =
      messages.calibration() ? std::optional(messages.calibration_at()) : std::nullopt;
  // A start that may never have been makes nobody wait longer.
  period_ = reassembler.period() > Duration(0) ? reassembler.period() : period_;
}

void LinkWatch::delivered(const Frame& frame) noexcept {
  heard_ = frame.last_packet;
  frame_at_ = frame.last_packet;
}

LinkState LinkWatch::state(Time now) const noexcept {
  const bool again = frame_at_ && restarted_at_ && *frame_at_ >= *restarted_at_;
  return {.silent = now - heard_ > silence_after(period_),
          .restarted = restarted_at_ && (now - *restarted_at_ < kRestartTold || !again),
          .forged_traffic = forged_at_ && now - *forged_at_ < kForgeryTold,
          .delayed = late_at_ && now - *late_at_ < kLateTold,
          .no_key = keys_refused_,
          .frame_age = age(frame_at_, now),
          .health_age = age(health_at_, now),
          .calibration_age = age(calibration_at_, now)};
}

}  // namespace stof::client

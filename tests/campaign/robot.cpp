#include "tests/campaign/robot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/base/fixed.h"
#include "firmware/wire/messages/conditions.h"

namespace stof::campaign {
namespace {

using namespace std::chrono_literals;

constexpr std::uint16_t kPort = 40'000;
constexpr hal::Duration kStereoExposure = 4ms;
constexpr hal::Duration kPmdExposure = 16ms;
// Conditions that say nothing of the frames.
constexpr std::uint32_t kHarmless = 1U << static_cast<unsigned>(wire::Condition::kUnpaired) |
                                    1U << static_cast<unsigned>(wire::Condition::kSettingsChanged) |
                                    1U << static_cast<unsigned>(wire::Condition::kPairing);

std::uint64_t troubles(const client::Statistics& s) noexcept {
  return s.truncated + s.bad_magic + s.bad_version + s.bad_length + s.bad_crc + s.bad_field +
         s.unknown + s.oversized + s.foreign + s.duplicate + s.late + s.old + s.implausible +
         s.frames_incomplete + s.frames_stale + s.frames_old + s.frames_lost + s.frames_dropped +
         s.socket_drops;
}

// The middle depth of a source's pixels, m; none where the frame has fewer than `least`.
std::optional<double> depth_of(const client::Frame& frame, dsp::Source source, std::size_t least) {
  std::vector<dsp::QuarterMm> found;
  for (int y = 0; y < frame.depth.height(); ++y) {
    for (int x = 0; x < frame.depth.width(); ++x) {
      constexpr std::uint8_t kBoth = client::kHasDepth | client::kHasSource;
      if (frame.source.width() > 0 && (frame.received.at(x, y) & kBoth) == kBoth &&
          frame.source.at(x, y) == source && frame.depth.at(x, y) != 0) {
        found.push_back(frame.depth.at(x, y));
      }
    }
  }
  if (found.size() < least) {
    return std::nullopt;
  }
  std::ranges::nth_element(found, found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2));
  return static_cast<double>(found[found.size() / 2]) / dsp::kQuarterMmPerMetre;
}

}  // namespace

hal::Peer Robot::peer() noexcept {
  return {.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 10, 0, 0, 2}, .port = kPort};
}

Robot::Robot(const EdgeLog& log, const Belief& belief, hal::Time start)
    : log_(log),
      size_(belief.truth),
      now_(client_time(start)),
      arrivals_({.monotonic = now_, .wall = wall(now_)}),
      reassembler_({.max_age = belief.max_age}),
      watch_(now_),
      subscription_({}, 1),
      unwell_until_(now_) {}

std::chrono::nanoseconds Robot::wall(client::Time at) const noexcept {
  constexpr std::chrono::nanoseconds kOffset = 1'700'000'000s;
  return at.time_since_epoch() + kOffset + (at >= jump_at_ ? jump_by_ : 0ns);
}

void Robot::note(client::Time at, Sign sign) {
  if (signs_.empty() || signs_.back().sign != sign || at - signs_.back().at > 5ms) {
    signs_.push_back({at, sign});
  }
}

void Robot::forget_records() {
  signs_.clear();
  whole_.clear();
}

void Robot::run(Network& network, hal::Time until) {
  while (now_ < client_time(until)) {
    const client::Time next = std::min(now_ + kLook, client_time(until));
    if (asleep_.begin <= hal::Time(next.time_since_epoch()) &&
        hal::Time(next.time_since_epoch()) < asleep_.end) {
      now_ = next;
      slept_ = true;
      continue;
    }
    if (std::exchange(slept_, false)) {
      now_ = next;  // all that waited is read now
    }
    read(network, next);
    now_ = next;
    look(now_);
    if (const auto request = subscription_.due(now_); !request.empty()) {
      network.to_sensor(request, peer());
    }
  }
}

// Reads at once what arrives, but what waited while it slept.
void Robot::read(Network& network, client::Time until) {
  while (const std::optional<Network::Arrival> arrival = network.next(until)) {
    push(network, *arrival, std::max(arrival->at, now_));
  }
}

void Robot::push(Network& network, const Network::Arrival& arrival, client::Time now) {
  const bool waited = arrival.at < now_;
  arrivals_.read({.monotonic = now, .wall = wall(now)});
  const client::Time arrived = arrivals_.arrival(wall(arrival.at));
  if (!waited) {
    arrivals_.emptied(now);
  }
  subscription_.heard(now);
  if (subscription_.take(arrival.bytes, now)) {
    if (const auto request = subscription_.due(now); !request.empty()) {
      network.to_sensor(request, peer());
    }
    return;
  }
  reassembler_.push(arrival.bytes, arrived, now);
  ++counts_.pushed;
  take(now);
}

void Robot::take(client::Time now) {
  while (const std::optional<client::Frame> frame = reassembler_.take(now)) {
    watch_.look(reassembler_, now);
    watch_.delivered(*frame);
    const Falsehood falsehood = judge(*frame, now);
    ++counts_.delivered;
    ++counts_.falsehoods[static_cast<std::size_t>(falsehood)];
    const bool flagged = frame->stamp.health != wire::Health::kOk ||
                         (frame->info && wire::sensors_of(*frame->info) != wire::kBothSensors);
    whole_now_ = frame->complete() && !flagged && falsehood == Falsehood::kNone;
    if (whole_now_) {
      ++counts_.whole;
      whole_.push_back(now);
    }
    if (!frame->complete()) {
      note(now, Sign::kIncomplete);
    }
    if (flagged) {
      note(now, Sign::kFlagged);
    }
  }
}

Falsehood Robot::judge(const client::Frame& frame, client::Time now) {
  const std::int64_t middle = frame.stamp.exposure_middle_ns;
  const auto edge_of = [&](hal::Duration exposure) {
    return log_.find(hal::Time(hal::Duration(middle)) - exposure / 2);
  };
  const client::Duration age = now.time_since_epoch() - std::chrono::nanoseconds(middle);
  counts_.oldest = std::max(counts_.oldest, age);
  if (age > kOldest) {
    return Falsehood::kStale;
  }
  if (newest_ns_ && middle <= *newest_ns_) {
    return Falsehood::kNotNewer;
  }
  newest_ns_ = middle;
  const bool pair = edge_of(kStereoExposure) < log_.count();
  const std::size_t edge = pair ? edge_of(kStereoExposure) : edge_of(kPmdExposure);
  if (edge == log_.count()) {
    return Falsehood::kNoEdge;
  }
  const double truth = size_.depth_m(edge);
  const std::size_t least = static_cast<std::size_t>(frame.depth.width()) *
                            static_cast<std::size_t>(frame.depth.height()) / 8;
  for (const dsp::Source source : {dsp::Source::kBoth, dsp::Source::kStereo, dsp::Source::kPmd}) {
    if (frame.depth.width() == 0) {
      break;
    }
    const std::optional<double> depth = depth_of(frame, source, least);
    // The middle of what a quarter of a pixel to both sides leaves of 4 m is 4.27 m.
    const double tolerance = source == dsp::Source::kStereo ? 0.07 : 0.03;
    if (depth && std::abs(*depth - truth) > tolerance * truth) {
      return Falsehood::kOtherPixels;
    }
    if (depth && frame.info) {
      const auto sensors = wire::sensors_of(*frame.info);
      const bool of_pair = source != dsp::Source::kPmd;
      const bool of_pmd = source != dsp::Source::kStereo;
      if ((of_pair && (sensors & wire::kStereoSensor) == 0) ||
          (of_pmd && (sensors & wire::kPmdSensor) == 0)) {
        return Falsehood::kWrongSensors;
      }
    }
  }
  return Falsehood::kNone;
}

void Robot::look(client::Time now) {
  reassembler_.expire(now);
  take(now);
  watch_.look(reassembler_, now);
  const client::LinkState link = watch_.state(now);
  if (link.silent || link.restarted || link.forged_traffic || link.delayed) {
    note(now, Sign::kLink);
  }
  const std::uint64_t counted = troubles(reassembler_.statistics());
  if (counted != troubles_) {
    note(now, Sign::kCounted);
  }
  troubles_ = counted;
  while (const auto event = reassembler_.take_event()) {
    const auto condition = static_cast<unsigned>(event->report.condition);
    if (event->report.active != 0 && (condition >= 32 || (kHarmless >> condition & 1U) == 0)) {
      note(now, Sign::kCondition);
    }
  }
  const auto& health = reassembler_.health();
  const bool sick = health && (health->active & ~kHarmless) != 0;
  if (sick) {
    note(now, Sign::kHealth);
  }
  if (sick || link.silent || !whole_now_) {
    unwell_until_ = now;
  }
}

}  // namespace stof::campaign

#include "firmware/pipeline/publisher.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include "dsp/base/check.h"
#include "firmware/wire/frame_info.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"

namespace stof::firmware {
namespace {

constexpr hal::Duration kCalibrationInterval = std::chrono::seconds(1);
// Datagrams that go to one receiver at once: its socket holds a fraction of a frame only.
constexpr std::size_t kBurst = 8;
// However long the period is, nobody waits longer for the end of a frame.
constexpr hal::Duration kLongestSpread = std::chrono::milliseconds(50);
// A frame whose sending takes longer than three periods, within these bounds, is not sent on; nor
// one that is three periods old, or a second where that is more: the program stood still.
constexpr hal::Duration kLeastSending = std::chrono::milliseconds(300);
constexpr hal::Duration kMostSending = std::chrono::seconds(1);

// The exposure that the frame is named by.
hal::Exposure exposure_of(const Shot& shot) noexcept {
  if (shot.stereo) {
    const hal::StereoFrame& stereo = **shot.stereo;
    return {std::min(stereo.left_exposure.begin, stereo.right_exposure.begin),
            std::max(stereo.left_exposure.end, stereo.right_exposure.end)};
  }
  const hal::PmdFrame& pmd = **shot.pmd;
  return {pmd.exposures.front().begin, pmd.exposures.back().end};
}

wire::FrameImages images_of(const Shot& shot, const Output& output) noexcept {
  wire::FrameImages images{.map = output.map,
                           .disparity = output.stereo.disparity,
                           .pmd = {},
                           .left = output.left,
                           .right = output.right};
  if (shot.pmd) {
    images.pmd = (*shot.pmd)->samples;
  }
  return images;
}

const hal::Peer* raw_receiver(const ReceiverList& list) noexcept {
  return list.raw_receiver < list.count ? &list.peers[list.raw_receiver] : nullptr;
}

}  // namespace

Publisher::Publisher(const PublisherSetup& setup, const wire::FrameSizes& sizes, hal::Clock& clock,
                     hal::DatagramPort& port, FrameListener* listener, Events& events,
                     dsp::Arena& arena) noexcept
    : setup_(setup),
      clock_(clock),
      port_(port),
      listener_(listener),
      events_(events),
      coder_(setup.origin, sizes, setup.calibration, arena, wire::FrameCoder::usual_packets(sizes)),
      health_(clock.now()),
      raw_(setup.origin, clock),
      signed_space_(arena.take<wire::DatagramBuffer>(kSignedAtOnce)),
      signed_raw_(arena.take<wire::DatagramBuffer>(RawSender::kBurst)) {}

void Publisher::set_params(const PublisherParams& params) noexcept {
  params_ = params;
  setup_.calibration.period_ns = params.period.count();
  raw_.set_period(params.period);
  raw_.set_search(params.pmd_every, params.disparities);
  if (params.max_range > 0) {
    setup_.calibration.max_range = params.max_range;
  }
  calibration_due_.reset();  // receivers go by it
  health_.note_blinding(params.blinding, clock_.now());
}

void Publisher::set_calibration(const wire::CalibrationPacket& calibration) noexcept {
  setup_.calibration = calibration;
  coder_.set_calibration(calibration);
  calibration_due_.reset();
}

bool Publisher::set_receivers(const ReceiverList& receivers) noexcept {
  static_assert(kMostSubscribers <= hal::DatagramPort::kShallowStream);
  std::array<std::optional<ReceiverWay>, kMostSubscribers> ways{};
  std::array<bool, kMostSubscribers> taken{};
  for (std::size_t i = 0; i < receivers.count; ++i) {
    for (std::size_t was = 0; was < receivers_.count && !ways[i]; ++was) {
      if (receivers_.peers[was] == receivers.peers[i] &&
          ways_[was].tagger.key().number == receivers.keys[i].number && !taken[ways_[was].stream]) {
        ways[i] = ways_[was];
        taken[ways_[was].stream] = true;
      }
    }
  }
  for (std::size_t i = 0; i < receivers.count; ++i) {
    if (!ways[i]) {
      const auto free = std::ranges::find(taken, false);
      *free = true;
      ways[i] = ReceiverWay{.stream = static_cast<std::size_t>(free - taken.begin()),
                            .tagger = wire::StreamTagger(receivers.keys[i])};
      calibration_due_.reset();
      health_wanted_ = true;
      health_.tell_release_again();
    }
    ways_[i] = *ways[i];
  }
  const hal::Peer* const had = raw_receiver(receivers_);
  const hal::Peer* const has = raw_receiver(receivers);
  const bool same = had != nullptr && has != nullptr && *had == *has;
  const bool asked = !same || receivers_.raw != receivers.raw;
  if (asked) {
    raw_.ask(has == nullptr ? wire::RawRequest{} : receivers.raw);
  }
  receivers_ = receivers;
  return asked && has != nullptr && (receivers.raw.pictures & wire::kRawAnew) != 0;
}

Status Publisher::publish(const Shot& shot, const Output& output, hal::Time latest) noexcept {
  const bool whole = shot.sensors() == rig_sensors() && shot.missed_edges == 0;
  stamp_ = wire::FrameStamp{
      .number = stamp_ ? stamp_->number + 1 : 0,
      .freshness = shot.freshness,
      .exposure_middle_ns = shot.exposed.time_since_epoch().count(),
      .health = std::max(health_.summary(), whole ? wire::Health::kOk : wire::Health::kDegraded),
      .clock = setup_.clock};
  const wire::FrameInfo info = describe(shot, output);
  if (listener_ != nullptr) {
    listener_->frame(*stamp_, info, output.map);
  }
  Status status = Status::kOk;
  times_ = {};
  if (receivers_.count > 0) {
    if (!calibration_due_ || clock_.now() >= *calibration_due_) {
      calibration_due_ = clock_.now() + kCalibrationInterval;
      encode_calibration_packet(
          setup_.calibration, wire::payload_space(buffer_).first<wire::kCalibrationPacketBytes>());
      status = send_one(wire::seal_packet(header(wire::PacketType::kCalibration),
                                          wire::kCalibrationPacketBytes, buffer_));
    }
    const Status sent = send_frame(shot, output, info, latest);
    status = status == Status::kOk || sent == Status::kDeviceLost ? sent : status;
  }
  if (receivers_.refused && status == Status::kOk && receivers_.count == 1) {
    status = Status::kDeviceError;  // sent nevertheless: whoever begins to listen misses nothing
  }
  const hal::Time now = clock_.now();
  const auto& sources = output.stats.sources;
  const auto pixels = std::accumulate(sources.begin(), sources.end(), std::uint64_t{0});
  const auto blind =
      std::uint64_t{of(sources, dsp::Source::kNone)} + of(sources, dsp::Source::kConflict);
  health_.note_coverage(pixels, pixels - blind);
  if ((shot.sensors() & kStereoSensor) != 0) {
    health_.note_matches(
        pixels, std::uint64_t{of(sources, dsp::Source::kStereo)} + of(sources, dsp::Source::kBoth));
  }
  health_.frame_sent(latency(shot, now), output.drift.significant, info.drift_significant, now);
  return status;
}

// Begins with the first datagrams, so that coding what does not lie in memory takes from the time
// between them.
class Publisher::Paced final : public wire::DatagramSink {
 public:
  // latest: when it ends; expiry: when what is left shows the past.
  Paced(Publisher& publisher, hal::Time latest, hal::Time expiry) noexcept
      : publisher_(publisher), latest_(latest), expiry_(expiry) {}

  void take(Datagrams datagrams, std::size_t all) noexcept override {
    hal::Clock& clock = publisher_.clock_;
    if (abandoned_) {
      publisher_.drop(datagrams.size());
      return;
    }
    if (sent_ == 0) {
      start_ = clock.now();
      budget_ = std::clamp(latest_ - start_, hal::Duration::zero(), kLongestSpread);
    }
    const std::size_t burst = budget_ > hal::Duration::zero() ? kBurst : datagrams.size();
    std::size_t prepared = 0;
    std::size_t prepared_end = 0;
    for (std::size_t at = 0; at < datagrams.size();) {
      const hal::Time due =
          start_ + budget_ * static_cast<std::int64_t>(sent_) / static_cast<std::int64_t>(all);
      const hal::Time ready = clock.now();
      if (due > ready) {
        publisher_.wait_until(due);
      }
      const hal::Time begin = clock.now();
      publisher_.times_.waited += begin - ready;
      if (begin > expiry_ || begin - start_ > publisher_.longest_sending()) {
        abandon(datagrams.size() - at);
        return;
      }
      if (at == prepared_end) {
        prepared = at;
        prepared_end = at + publisher_.prepare(datagrams.subspan(at));
      }
      const std::size_t count = std::min(burst, prepared_end - at);
      const Status sent = publisher_.send(at - prepared, count);
      publisher_.times_.send += clock.now() - begin;
      status_ = status_ == Status::kOk || sent == Status::kDeviceLost ? sent : status_;
      sent_ += count;
      at += count;
    }
  }

  Status status() const noexcept { return status_; }

 private:
  // What is left of the frame has become old: who gets it later would take it for new.
  void abandon(std::size_t datagrams) noexcept {
    abandoned_ = true;
    status_ = Status::kWouldBlock;
    ++publisher_.events_.counters.expired;
    publisher_.drop(datagrams);
  }

  Publisher& publisher_;
  hal::Time latest_;
  hal::Time expiry_;
  hal::Time start_{};
  hal::Duration budget_{};
  std::size_t sent_ = 0;
  Status status_ = Status::kOk;
  bool abandoned_ = false;
};

Status Publisher::send_frame(const Shot& shot, const Output& output, const wire::FrameInfo& info,
                             hal::Time latest) noexcept {
  const hal::Time start = clock_.now();
  Paced paced(*this, std::min(start + params_.period * params_.pace_percent / 100, latest),
              shot.edge + std::max<hal::Duration>(3 * params_.period, kMostSending));
  const Status coded = coder_.code(*stamp_, info, images_of(shot, output), params_.choice, paced);
  times_.code = clock_.now() - start - times_.send - times_.waited;
  return coded == Status::kOk ? paced.status() : coded;
}

hal::Duration Publisher::longest_sending() const noexcept {
  return std::clamp(3 * params_.period, kLeastSending, kMostSending);
}

void Publisher::drop(std::size_t datagrams) noexcept {
  events_.counters.packets_dropped += datagrams * receivers_.count;
}

// kDeviceError only where nobody at all could be reached.
Status Publisher::send(std::size_t first, std::size_t count) noexcept {
  Status status = Status::kOk;
  std::size_t unreachable = 0;
  for (std::size_t i = 0; i < receivers_.count; ++i) {
    const Delivery delivery = deliver(i, ways_[i].prepared.subspan(first, count));
    if (delivery.lost) {
      const std::size_t others = receivers_.count - i - 1;  // whose turn has not come
      events_.counters.packets_dropped += delivery.left + others * count;
      return Status::kDeviceLost;
    }
    status = delivery.dropped ? Status::kWouldBlock : status;
    unreachable += delivery.reached ? 0 : 1;
  }
  return unreachable > 0 && unreachable == receivers_.count ? Status::kDeviceError : status;
}

Publisher::Delivery Publisher::deliver(std::size_t receiver, Datagrams datagrams) noexcept {
  Counters& counters = events_.counters;
  Delivery delivery;
  for (std::size_t at = 0; at < datagrams.size();) {
    std::size_t sent = 0;
    const Status taken = port_.stream(ways_[receiver].stream, receivers_.peers[receiver],
                                      datagrams.subspan(at), sent);
    counters.packets_sent += sent;
    at += sent;
    delivery.reached = delivery.reached || taken != Status::kDeviceError;
    if (taken == Status::kDeviceLost) {
      delivery.lost = true;
      delivery.left = datagrams.size() - at;
      return delivery;
    }
    if (at < datagrams.size()) {  // this one is lost, the next one is tried
      ++counters.packets_dropped;
      ++at;
      delivery.dropped = delivery.dropped || taken != Status::kDeviceError;
    }
  }
  return delivery;
}

std::size_t Publisher::prepare(Datagrams datagrams) noexcept {
  const std::span<ReceiverWay> ways = std::span(ways_).first(receivers_.count);
  const auto signing = static_cast<std::size_t>(std::ranges::count_if(ways, &ReceiverWay::signs));
  const std::size_t count =
      signing == 0 ? datagrams.size()
                   : std::min(datagrams.size(), kSignedAtOnce / signing / kBurst * kBurst);
  std::size_t at = 0;
  for (ReceiverWay& way : ways) {
    way.prepared = datagrams.first(count);
    if (way.signs()) {
      const std::size_t begin = at;
      for (const std::span<const std::byte> datagram : datagrams.first(count)) {
        signed_[at] = way.sign(datagram, signed_space_[at]);
        ++at;
      }
      way.prepared = std::span(signed_).subspan(begin, count);
    }
  }
  return count;
}

// One receiver's, by a queue that holds little: what waits in it never keeps a frame for long.
class Publisher::RawWay final : public RawSender::Way {
 public:
  explicit RawWay(Publisher& publisher) noexcept : publisher_(publisher) {}
  Status send_raw(Datagrams datagrams, std::size_t& sent) noexcept override {
    return publisher_.send_raw(datagrams, sent);
  }

 private:
  Publisher& publisher_;
};

void Publisher::offer_raw(Shot& shot, hal::Time until) noexcept {
  if (stamp_) {
    RawWay way(*this);
    raw_.hurry(until, way);
    raw_.offer(shot, *stamp_);
  }
}

void Publisher::wait_until(hal::Time time) noexcept {
  RawWay way(*this);
  raw_.send_until(time, way);
  clock_.wait_until(time);
}

Status Publisher::send_raw(Datagrams datagrams, std::size_t& sent) noexcept {
  const std::size_t receiver = receivers_.raw_receiver;
  std::array<std::span<const std::byte>, RawSender::kBurst> made;
  if (ways_[receiver].signs()) {
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      made[i] = ways_[receiver].sign(datagrams[i], signed_raw_[i]);
    }
    datagrams = std::span(made).first(datagrams.size());
  }
  const Status status =
      port_.stream(hal::DatagramPort::kShallowStream, receivers_.peers[receiver], datagrams, sent);
  events_.counters.packets_sent += sent;
  return status;
}

Status Publisher::send_one(std::span<const std::byte> datagram) noexcept {
  const std::array<std::span<const std::byte>, 1> one{datagram};
  return send(0, prepare(one));
}

void Publisher::tell(wire::PacketType type, std::size_t bytes) noexcept {
  const std::span<const std::byte> datagram = wire::seal_packet(header(type), bytes, buffer_);
  static_cast<void>(send_one(datagram));  // counted there; frames tell what the link does
  if (listener_ != nullptr) {
    listener_->packet(datagram);
  }
}

void Publisher::report_events() noexcept {
  const hal::Time now = clock_.now();
  while (const std::optional<wire::EventReport> event = health_.next_event(now)) {
    encode_event_report(*event, wire::payload_space(buffer_).first<wire::kEventReportBytes>());
    tell(wire::PacketType::kEvent, wire::kEventReportBytes);
  }
}

void Publisher::report(const ControlStatus& control) noexcept {
  report_events();
  const hal::Time now = clock_.now();
  const std::optional<wire::HealthReport> health =
      health_.next_health(events_.counters, control, std::exchange(health_wanted_, false), now);
  if (health) {
    encode_health_report(*health, wire::payload_space(buffer_).first<wire::kHealthReportBytes>());
    tell(wire::PacketType::kHealth, wire::kHealthReportBytes);
  }
}

wire::Header Publisher::header(wire::PacketType type) const noexcept {
  wire::FrameStamp stamp = stamp_.value_or(wire::FrameStamp{});
  stamp.health = std::max(stamp.health, health_.summary());
  stamp.clock = setup_.clock;
  return {.type = type,
          .origin = setup_.origin,
          .frame = stamp,
          .image_width = setup_.calibration.image_width,
          .image_height = setup_.calibration.image_height};
}

Sensors Publisher::rig_sensors() const noexcept {
  return setup_.calibration.pmd_width > 0 ? kBothSensors : kStereoSensor;
}

// 0: not measured. Of what is computed again the clock is the recording's.
hal::Duration Publisher::latency(const Shot& shot, hal::Time now) const noexcept {
  return setup_.clock == wire::ClockState::kRecorded ? hal::Duration(0) : now - shot.exposed;
}

wire::FrameInfo Publisher::describe(const Shot& shot, const Output& output) const noexcept {
  const hal::Exposure exposure = exposure_of(shot);
  wire::FrameInfo info{
      .exposure_begin_ns = exposure.begin.time_since_epoch().count(),
      .exposure_end_ns = exposure.end.time_since_epoch().count(),
      .pmd_age_ns = shot.pmd_exposed ? (shot.exposed - *shot.pmd_exposed).count() : 0,
      .compute_ns = output.stats.total().count(),
      .latency_ns = latency(shot, clock_.now()).count(),
      .pixels_by_source = output.stats.sources,
      .counters = loop_counters(events_.counters),
      .pixels_by_cause = output.stats.causes,
      .drift_patches = output.drift.patches,
      .pmd_present = static_cast<std::uint8_t>(shot.pmd_exposed ? 1 : 0),
      .sensors = shot.sensors(),
      .settings_revision = params_.revision,
      .stage_us = {microseconds(output.stats.convert), microseconds(output.stats.match),
                   microseconds(output.stats.fuse), microseconds(output.stats.watch),
                   microseconds(times_.code), microseconds(times_.send)},
      .steady_frames = output.steady_frames,
      .settings_fingerprint = params_.fingerprint,
      .calibration_fingerprint = setup_.calibration.fingerprint,
      .max_range_um = setup_.calibration.max_range * setup_.calibration.depth_unit_um,
      .period_ns = setup_.calibration.period_ns};
  static_assert(wire::kDrifts == dsp::kDriftParameters);
  for (std::size_t i = 0; i < wire::kDrifts; ++i) {
    const dsp::Drift& drift = output.drift.drifts[i];
    info.drifts[i] = {.value = drift.value, .sigma = drift.sigma};
    info.drift_significant |= drift.significant ? 1U << i : 0U;
  }
  return info;
}

}  // namespace stof::firmware

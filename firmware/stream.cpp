#include "firmware/stream.h"

#include <algorithm>
#include <chrono>

namespace stof::firmware {
namespace {

constexpr hal::Duration kCalibrationInterval = std::chrono::seconds(1);

std::uint32_t packets_of(const dsp::DepthMap& map) noexcept {
  const auto width = static_cast<std::size_t>(map.depth.width());
  const auto height = static_cast<std::size_t>(map.depth.height());
  return static_cast<std::uint32_t>(1 +
                                    2 * wire::tile_count(width, height, sizeof(dsp::QuarterMm)) +
                                    wire::tile_count(width, height, sizeof(dsp::Source)));
}

std::uint64_t mispaired(const Counters& counters) noexcept {
  std::uint64_t sum = 0;
  for (std::size_t cause = 0; cause < kDrops; ++cause) {
    if (cause != static_cast<std::size_t>(Drop::kUnpartnered)) {
      sum += counters.stereo_dropped[cause] + counters.pmd_dropped[cause];
    }
  }
  return sum;
}

}  // namespace

void PacedLink::begin(std::uint32_t packets, hal::Time latest) noexcept {
  start_ = clock_.now();
  budget_ = std::max(latest - start_, hal::Duration::zero());
  packets_ = packets;
  sent_ = 0;
}

Status PacedLink::send(std::span<const std::byte> datagram) noexcept {
  if (sent_ % kBurst == 0 && sent_ < packets_) {
    const hal::Time due = start_ + budget_ * sent_ / packets_;
    if (due > clock_.now()) {
      clock_.wait_until(due);
    }
  }
  ++sent_;
  return link_.send(datagram);
}

Status Stream::publish(const Shot& shot, const Output& output, hal::Time latest) noexcept {
  const wire::FrameStamp stamp{
      .number = number_++,
      .freshness = shot.freshness,
      .exposure_middle_ns = shot.exposed.time_since_epoch().count(),
      .health = shot.missed_edges == 0 ? wire::Health::kOk : wire::Health::kDegraded,
      .clock = setup_.clock};
  Counters& counters = events_.counters;
  const bool calibrate = !calibration_due_ || clock_.now() >= *calibration_due_;
  Status first = Status::kOk;
  paced_.begin(packets_of(output.map) + (calibrate ? 1 : 0), latest);
  if (calibrate) {
    calibration_due_ = clock_.now() + kCalibrationInterval;
    first = packetizer_.publish(stamp, setup_.calibration);
    ++(first == Status::kOk ? counters.packets_sent : counters.packets_dropped);
  }
  const wire::Sent sent = packetizer_.publish(stamp, describe(shot, output), output.map);
  counters.packets_sent += sent.packets - sent.dropped;
  counters.packets_dropped += sent.dropped;
  return first == Status::kOk || sent.status == Status::kDeviceLost ? sent.status : first;
}

wire::FrameInfo Stream::describe(const Shot& shot, const Output& output) const noexcept {
  const Counters& counters = events_.counters;
  const hal::StereoFrame& stereo = *shot.stereo;
  wire::FrameInfo info;
  info.exposure_begin_ns =
      std::min(stereo.left_exposure.begin, stereo.right_exposure.begin).time_since_epoch().count();
  info.exposure_end_ns =
      std::max(stereo.left_exposure.end, stereo.right_exposure.end).time_since_epoch().count();
  info.pmd_present = shot.pmd_exposed ? 1 : 0;
  info.pmd_age_ns = shot.pmd_exposed ? (shot.exposed - *shot.pmd_exposed).count() : 0;
  info.compute_ns = output.stats.total().count();
  info.latency_ns = (clock_.now() - shot.exposed).count();
  static_assert(kSources == wire::kSources);
  info.pixels_by_source = output.stats.sources;
  static_assert(kCauses == wire::kCauses && dsp::kDriftParameters == wire::kDrifts);
  info.pixels_by_cause = output.stats.causes;
  for (std::size_t i = 0; i < wire::kDrifts; ++i) {
    const dsp::Drift& drift = output.drift.drifts[i];
    info.drifts[i] = {.value = drift.value, .sigma = drift.sigma};
    info.drift_significant |= drift.significant ? 1U << i : 0U;
  }
  info.drift_patches = output.drift.patches;
  info.counters = {
      .edges = counters.edges,
      .frames_published = counters.published,
      .mispaired = mispaired(counters),
      .timeouts = of(counters.timeouts, Part::kStereo) + of(counters.timeouts, Part::kPmd),
      .deadline_misses = counters.skipped_periods + counters.expired,
      .link_drops = counters.packets_dropped};
  return info;
}

}  // namespace stof::firmware

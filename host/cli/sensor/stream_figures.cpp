#include "host/cli/sensor/stream_figures.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "host/cli/view/status_line.h"
#include "host/evaluate/stereo/median.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kNsPerMs = 1e6;

std::optional<Spread> spread_of(const std::vector<double>& values) {
  if (values.empty()) {
    return std::nullopt;
  }
  return Spread{.mean = std::accumulate(values.begin(), values.end(), 0.0) /
                        static_cast<double>(values.size()),
                .median = *percentile(values, 0.50),
                .p99 = *percentile(values, 0.99),
                .longest = *std::ranges::max_element(values)};
}

struct NamedCount {
  const char* name;
  std::uint64_t client::Statistics::* count;
};

constexpr std::array<NamedCount, 6> kFrameCounts{{
    {"whole", &client::Statistics::frames_complete},
    {"incomplete", &client::Statistics::frames_incomplete},
    {"lost", &client::Statistics::frames_lost},
    {"stale", &client::Statistics::frames_stale},
    {"old", &client::Statistics::frames_old},
    {"dropped", &client::Statistics::frames_dropped},
}};
constexpr std::array<NamedCount, 19> kPacketCounts{{
    {"ok", &client::Statistics::packets_ok},
    {"missing", &client::Statistics::packets_missing},
    {"recovered", &client::Statistics::recovered},
    {"socket_drops", &client::Statistics::socket_drops},
    {"truncated", &client::Statistics::truncated},
    {"bad_magic", &client::Statistics::bad_magic},
    {"bad_version", &client::Statistics::bad_version},
    {"bad_length", &client::Statistics::bad_length},
    {"bad_crc", &client::Statistics::bad_crc},
    {"bad_field", &client::Statistics::bad_field},
    {"unknown", &client::Statistics::unknown},
    {"oversized", &client::Statistics::oversized},
    {"foreign", &client::Statistics::foreign},
    {"duplicate", &client::Statistics::duplicate},
    {"late", &client::Statistics::late},
    {"old", &client::Statistics::old},
    {"implausible", &client::Statistics::implausible},
    {"not_signed", &client::Statistics::not_signed},
    {"forged", &client::Statistics::forged},
}};

}  // namespace

void StreamFigures::take(const client::Frame& frame, double arrived_s) {
  if (!begins_ && arrived_s < newest_s_) {
    ++arrivals_back_;
    measure_anew();
  }
  if (std::exchange(begins_, false)) {
    oldest_s_ = arrived_s;
  } else {
    intervals_ms_.push_back(1e3 * (arrived_s - newest_s_));
  }
  newest_s_ = arrived_s;
  ++frames_;
  if (!frame.depth.empty()) {
    coverage_ += host::coverage(frame);
    ++covered_frames_;
  }
  if (const std::optional<double> latency = host::latency_ms(frame)) {
    latencies_ms_.push_back(*latency);
  }
  // 0: the sensor did not measure it.
  if (frame.info && frame.info->latency_ns > 0) {
    sensor_latencies_ms_.push_back(static_cast<double>(frame.info->latency_ns) / kNsPerMs);
  }
  if (frame.info && frame.info->compute_ns > 0) {
    compute_ms_.push_back(static_cast<double>(frame.info->compute_ns) / kNsPerMs);
  }
  const std::int64_t stamp_ns = frame.stamp.exposure_middle_ns;
  if (!origin_ || origin_->session_id != frame.origin.session_id) {
    origin_ = frame.origin;
  } else if (stamp_ns < newest_stamp_ns_) {
    ++stamps_back_;
  }
  newest_stamp_ns_ = stamp_ns;
}

void StreamFigures::measure_anew() noexcept {
  earlier_s_ = seconds();
  oldest_s_ = newest_s_;
  streams_ += begins_ ? 0U : 1U;
  begins_ = true;
}

void StreamFigures::begin_anew() noexcept {
  measure_anew();
  origin_.reset();
}

std::optional<double> StreamFigures::rate_hz() const {
  return seconds() > 0 ? std::optional(static_cast<double>(frames_ - streams_) / seconds())
                       : std::nullopt;
}

std::optional<Spread> StreamFigures::interval_ms() const { return spread_of(intervals_ms_); }
std::optional<Spread> StreamFigures::latency_ms() const { return spread_of(latencies_ms_); }
std::optional<Spread> StreamFigures::sensor_latency_ms() const {
  return spread_of(sensor_latencies_ms_);
}
std::optional<Spread> StreamFigures::compute_ms() const { return spread_of(compute_ms_); }

std::optional<double> StreamFigures::coverage() const {
  return covered_frames_ == 0 ? std::nullopt
                              : std::optional(coverage_ / static_cast<double>(covered_frames_));
}

nlohmann::ordered_json spread_json(const std::optional<Spread>& spread) {
  if (!spread) {
    return nullptr;
  }
  return {{"mean", spread->mean},
          {"median", spread->median},
          {"p99", spread->p99},
          {"longest", spread->longest}};
}

std::string spread_text(const std::optional<Spread>& spread) {
  return spread ? printed("%.1f mean, %.1f median, %.1f p99, %.1f longest", spread->mean,
                          spread->median, spread->p99, spread->longest)
                : "-";
}

nlohmann::ordered_json statistics_json(const client::Statistics& statistics) {
  nlohmann::ordered_json json;
  for (const NamedCount& one : kFrameCounts) {
    json["frames"][one.name] = statistics.*one.count;
  }
  for (const NamedCount& one : kPacketCounts) {
    json["packets"][one.name] = statistics.*one.count;
  }
  return json;
}

}  // namespace stof::host

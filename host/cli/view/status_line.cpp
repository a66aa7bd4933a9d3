#include "host/cli/view/status_line.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "host/cli/sensor_text.h"
#include "host/evaluate/stereo/median.h"
#include "host/text/printed.h"
#include "host/viewer/status_message.h"

namespace stof::host {
namespace {

double seconds(client::Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

std::string error_text(const DepthScore& score) {
  return printed(", error %.1f mm median, E5 %.3f", 1000 * score.median_error_m.value_or(0),
                 score.e5);
}

}  // namespace

std::optional<double> latency_ms(const client::Frame& frame) {
  if (frame.stamp.clock != wire::ClockState::kMonotonic) {
    return std::nullopt;
  }
  // A stamp may hold any number: of other machines, of a faulty sensor, forged.
  constexpr double kMostMs = 60'000;
  const std::chrono::nanoseconds arrived = frame.last_packet.time_since_epoch();
  const double ms =
      (static_cast<double>(arrived.count()) - static_cast<double>(frame.stamp.exposure_middle_ns)) /
      1e6;
  return std::abs(ms) <= kMostMs ? std::optional(ms) : std::nullopt;
}

double coverage(const client::Frame& frame) {
  std::size_t covered = 0;
  for (int y = 0; y < frame.depth.height(); ++y) {
    for (const dsp::QuarterMm depth : frame.depth.row(y)) {
      covered += depth != dsp::kNoDepth ? 1U : 0U;
    }
  }
  const double pixels = static_cast<double>(frame.depth.width()) * frame.depth.height();
  return pixels == 0 ? 0 : static_cast<double>(covered) / pixels;
}

std::string drift_text(const wire::FrameInfo& info) {
  struct Unit {
    const char* name;
    const char* unit;
    double scale;
  };
  constexpr double kDegree = 180e-6 / std::numbers::pi;
  constexpr std::array<Unit, wire::kDrifts> kUnits{{{"pitch", "deg", kDegree},
                                                    {"yaw", "deg", kDegree},
                                                    {"roll", "deg", kDegree},
                                                    {"range", "mm", 1.0 / 16},
                                                    {"disparity", "px", 1e-3}}};
  std::string all;
  for (std::size_t i = 0; i < kUnits.size(); ++i) {
    const wire::DriftReading& drift = info.drifts[i];
    if (wire::significant(info, i)) {
      all += printed("%s %s %.3f +- %.3f %s", all.empty() ? "" : ",", kUnits[i].name,
                     drift.value * kUnits[i].scale, drift.sigma * kUnits[i].scale, kUnits[i].unit);
    }
  }
  return all.empty() ? all : ", drift:" + all + ": calibrate the rig anew";
}

void StatusLine::count(const client::Frame& frame) {
  if (frame.info) {
    drift_ = drift_text(*frame.info);
    if (frame.calibration && frame.calibration->pmd_width > 0) {
      ++by_sensors_[wire::sensors_of(*frame.info)];
    }
  }
  if (began_) {
    ++intervals_;
  } else {
    began_ = since_ = counted_from_ = frame.last_packet;
  }
  newest_ = frame.last_packet;
  ++frames_;
  coverage_ += coverage(frame);
  if (const std::optional<double> latency = latency_ms(frame)) {
    latencies_ms_.push_back(*latency);
  }
}

double StatusLine::rate() const {
  const double span = seconds(newest_ - counted_from_);
  return span > 0 ? static_cast<double>(intervals_) / span : 0;
}

std::string StatusLine::line(client::Time now, const client::Statistics& statistics,
                             const std::optional<DepthScore>& score) {
  std::string result =
      printed("%6.1f s  %5.1f frames/s", seconds(now - began_.value_or(now)), rate());
  if (!latencies_ms_.empty()) {
    result += printed(", latency %.1f / %.1f ms (p50 / p99)", *percentile(latencies_ms_, 0.50),
                      *percentile(latencies_ms_, 0.99));
  }
  if (frames_ > 0) {
    result += printed(", coverage %.1f %%", 100 * coverage_ / static_cast<double>(frames_));
  }
  for (const wire::Sensors sensors : {wire::kStereoSensor, wire::kPmdSensor}) {
    if (const std::uint64_t frames = by_sensors_[sensors]; frames > 0) {
      result += printed(", %llu frames of %s", static_cast<unsigned long long>(frames),
                        alone_text(sensors));
    }
  }
  if (score) {
    result += error_text(*score);
  }
  result += printed(", lost %llu packets %llu frames",
                    static_cast<unsigned long long>(statistics.packets_missing),
                    static_cast<unsigned long long>(viewer::lost_frames(statistics)));
  if (statistics.recovered != 0) {
    result += printed(", recovered %llu", static_cast<unsigned long long>(statistics.recovered));
  }
  result += drift_;
  since_ = now;
  counted_from_ = newest_;
  intervals_ = 0;
  frames_ = 0;
  by_sensors_ = {};
  coverage_ = 0;
  latencies_ms_.clear();
  return result;
}

std::string summary_line(const client::Statistics& statistics) {
  const std::uint64_t received = statistics.frames_complete + statistics.frames_incomplete;
  std::string result =
      printed("%llu frames received, %llu verified whole (every packet there, every CRC right), ",
              static_cast<unsigned long long>(received),
              static_cast<unsigned long long>(statistics.frames_complete));
  if (statistics.recovered != 0) {
    result += printed("%llu packets made of parity, ",
                      static_cast<unsigned long long>(statistics.recovered));
  }
  const std::pair<std::uint64_t, const char*> causes[] = {
      {statistics.packets_missing, "packets missing"},
      {statistics.frames_lost, "frames lost whole"},
      {statistics.frames_stale, "frames stale"},
      {statistics.frames_old, "frames too old"},
      {statistics.frames_dropped, "frames dropped"},
      {statistics.socket_drops, "datagrams dropped by a full socket"},
      {statistics.bad_crc, "packets damaged (CRC)"},
      {statistics.truncated, "packets cut short"},
      {statistics.bad_length, "packets of wrong length"},
      {statistics.bad_field, "packets contradicting themselves"},
      {statistics.bad_magic, "datagrams not ours"},
      {statistics.bad_version, "packets of an unknown version"},
      {statistics.unknown, "packets of an unknown kind"},
      {statistics.oversized, "packets of too large an image"},
      {statistics.foreign, "packets of another sensor"},
      {statistics.duplicate, "packets twice"},
      {statistics.late, "packets late"},
      {statistics.old, "packets too old"},
      {statistics.implausible, "packets that no sensor can have sent (forged, or a fault)"},
      {statistics.not_signed, "packets not signed for this program"},
      {statistics.forged, "packets with a wrong signature"},
      {statistics.events_dropped, "events dropped"}};
  std::string lost;
  for (const auto& [count, cause] : causes) {
    if (count != 0) {
      add_to(lost, std::to_string(count) + " " + cause);
    }
  }
  return result + (lost.empty() ? "nothing lost" : lost);
}

}  // namespace stof::host

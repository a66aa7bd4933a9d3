#include "host/lib/convert.h"

#include <algorithm>
#include <array>
#include <chrono>

#include "firmware/wire/frame_info.h"
#include "firmware/wire/messages/conditions.h"

namespace stof::lib {
namespace {

using wire::Stream;

constexpr double kFixed16 = 65536;
constexpr double kFixed30 = 1 << 30;
constexpr double kNano = 1e-9;

// All of it arrived.
template <typename T>
stof_plane to_whole_plane(const dsp::ImageView<const T>& view) noexcept {
  stof_plane plane{};
  if (view.empty()) {
    return plane;
  }
  const std::size_t rows = static_cast<std::size_t>(view.height());
  plane.data = view.data();
  plane.width = static_cast<std::uint32_t>(view.width());
  plane.height = static_cast<std::uint32_t>(view.height());
  plane.pixel_bytes = sizeof(T);
  plane.stride = static_cast<std::size_t>(view.stride()) * sizeof(T);
  plane.bytes = (rows - 1) * plane.stride + plane.width * sizeof(T);
  return plane;
}

template <typename T>
stof_plane to_plane(const dsp::ImageView<const T>& view, const client::Frame& frame,
                    Stream stream) noexcept {
  stof_plane plane = to_whole_plane(view);
  if (view.empty()) {
    return plane;
  }
  plane.missing = frame.missing_pixels(stream);
  const auto& marks = frame.marks[client::index_of(stream)];
  if (dsp::same_size(marks, view)) {
    plane.marks = marks.data();
    plane.marks_stride = static_cast<std::size_t>(marks.stride());
    plane.mark = client::mark_of(stream);
  }
  return plane;
}

std::int64_t since_boot_ns(client::Time time) noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

stof_info to_info(const wire::FrameInfo& info) noexcept {
  stof_info out{};
  out.exposure_begin_ns = info.exposure_begin_ns;
  out.exposure_end_ns = info.exposure_end_ns;
  out.pmd_age_ns = info.pmd_age_ns;
  out.compute_ns = info.compute_ns;
  out.latency_ns = info.latency_ns;
  std::ranges::copy(info.pixels_by_source, out.pixels_by_source);
  std::ranges::copy(info.pixels_by_cause, out.pixels_by_cause);
  out.settings_revision = info.settings_revision;
  out.pmd_present = info.pmd_present;
  out.cloud_step = info.cloud_step;
  out.sensors = wire::sensors_of(info);
  return out;
}

// The four samples lie below each other in one image of marks.
stof_plane to_sample_plane(const client::Frame& frame, std::size_t sample) noexcept {
  const auto& view = frame.pmd[sample];
  stof_plane plane = to_plane(view, frame, Stream::kPmdRaw);
  const auto& marks = frame.marks[client::index_of(Stream::kPmdRaw)];
  if (!view.empty() && marks.width() == view.width() && marks.height() == 4 * view.height()) {
    plane.marks = marks.row(static_cast<int>(sample) * view.height()).data();
    plane.marks_stride = static_cast<std::size_t>(marks.stride());
    plane.mark = client::mark_of(Stream::kPmdRaw);
  }
  return plane;
}

}  // namespace

void give_text(std::string_view text, char* out, std::size_t size) noexcept {
  if (out != nullptr && size > 0) {
    const std::size_t fits = std::min(text.size(), size - 1);
    std::memcpy(out, text.data(), fits);
    out[fits] = '\0';
  }
}

stof_status to_status(Status status) noexcept {
  switch (status) {
    case Status::kOk:
      return STOF_OK;
    case Status::kTimeout:
      return STOF_TIMEOUT;
    case Status::kInvalidArgument:
      return STOF_BAD_ARGUMENT;
    case Status::kDeviceError:
      return STOF_UNREACHABLE;
    case Status::kDeviceLost:
      return STOF_LOST;
    case Status::kTooLarge:
      return STOF_TOO_SMALL;
    case Status::kUnsupported:
      return STOF_UNSUPPORTED;
    case Status::kWouldBlock:
    case Status::kCorrupt:
      return STOF_UNREACHABLE;
  }
  return STOF_INTERNAL;
}

stof_calibration to_calibration(const wire::CalibrationPacket& packet) noexcept {
  stof_calibration out{};
  out.width = packet.image_width;
  out.height = packet.image_height;
  out.fx = packet.fx / kFixed16;
  out.fy = packet.fy / kFixed16;
  out.cx = packet.cx / kFixed16;
  out.cy = packet.cy / kFixed16;
  out.doff = packet.doff / kFixed16;
  std::ranges::copy(std::array{out.fx, 0.0, out.cx, 0.0, out.fy, out.cy, 0.0, 0.0, 1.0}, out.k);
  out.baseline_m = static_cast<double>(packet.baseline_nm) * kNano;
  out.depth_unit_m = packet.depth_unit_um * 1e-6;
  out.max_range_m = packet.max_range * out.depth_unit_m;
  out.period_s = static_cast<double>(packet.period_ns) * kNano;
  out.pmd_width = packet.pmd_width;
  out.pmd_height = packet.pmd_height;
  out.modulation_hz = packet.modulation_hz;
  std::ranges::transform(packet.rotation, out.r, [](std::int32_t v) { return v / kFixed30; });
  std::ranges::transform(packet.translation_nm, out.t,
                         [](std::int64_t v) { return static_cast<double>(v) * kNano; });
  return out;
}

stof_frame to_frame(const Taken& taken) noexcept {
  const client::Frame& frame = taken.frame;
  stof_frame out{};
  out.device_id = frame.origin.device_id;
  out.session_id = frame.origin.session_id;
  out.number = frame.stamp.number;
  out.freshness = frame.stamp.freshness;
  out.health = static_cast<std::uint32_t>(frame.stamp.health);
  out.exposure_middle_ns = frame.stamp.exposure_middle_ns;
  out.first_packet_ns = since_boot_ns(frame.first_packet);
  out.last_packet_ns = since_boot_ns(frame.last_packet);
  out.packets = frame.packets;
  out.missing_packets = frame.missing_packets;
  out.recovered_packets = frame.recovered_packets;
  out.emulated = static_cast<std::uint8_t>(frame.stamp.clock);
  out.depth = to_plane(frame.depth, frame, Stream::kDepth);
  out.interval_width = to_plane(frame.interval_width, frame, Stream::kWidth);
  out.source = to_plane(frame.source, frame, Stream::kSource);
  out.cause = to_plane(frame.cause, frame, Stream::kSource);
  out.disparity = to_plane(frame.disparity, frame, Stream::kDisparity);
  for (std::size_t sample = 0; sample < frame.pmd.size(); ++sample) {
    out.pmd[sample] = to_sample_plane(frame, sample);
  }
  out.left = to_plane(frame.left, frame, Stream::kGreyLeft);
  out.right = to_plane(frame.right, frame, Stream::kGreyRight);
  out.cloud = to_plane(frame.cloud, frame, Stream::kCloud);
  if (frame.info) {
    out.has_info = 1;
    out.info = to_info(*frame.info);
    out.settings_fingerprint = frame.info->settings_fingerprint;
    out.steady_frames = frame.info->steady_frames;
    out.calibration_fingerprint = frame.info->calibration_fingerprint;
  }
  if (frame.calibration) {
    out.has_calibration = 1;
    out.calibration = to_calibration(*frame.calibration);
  }
  out.self = &taken;
  out.exposure_here_ns = taken.exposure_here_ns;
  out.recorded_ns = taken.recorded_ns;
  return out;
}

stof_health to_health(const wire::HealthReport& report) noexcept {
  stof_health out{};
  out.active = report.active;
  out.severity = static_cast<std::uint32_t>(report.severity);
  out.reaction = static_cast<std::uint32_t>(report.reaction);
  out.uptime_ms = report.uptime_ms;
  out.rate_hz = report.rate_millihertz * 1e-3;
  out.latency_s = report.latency_us * 1e-6;
  out.longest_latency_s = report.longest_latency_us * 1e-6;
  out.frames_published = report.counters.frames_published;
  out.packets_sent = report.packets_sent;
  out.subscribers = report.subscribers;
  out.settings_revision = report.settings_revision;
  out.edges = report.counters.edges;
  out.mispaired = report.counters.mispaired;
  out.timeouts = report.counters.timeouts;
  out.deadline_misses = report.counters.deadline_misses;
  out.link_drops = report.counters.link_drops;
  out.accepted = report.control.accepted;
  out.truncated = report.control.truncated;
  out.bad_magic = report.control.bad_magic;
  out.bad_version = report.control.bad_version;
  out.bad_length = report.control.bad_length;
  out.bad_crc = report.control.bad_crc;
  out.bad_field = report.control.bad_field;
  out.not_control = report.control.not_control;
  out.foreign = report.control.foreign;
  out.too_short = report.control.too_short;
  out.cookies = report.control.cookies;
  out.busy = report.control.busy;
  out.overrun = report.control.overrun;
  out.forged = report.control.forged;
  out.replayed = report.control.replayed;
  out.serial_sent = report.serial_sent;
  out.serial_dropped = report.serial_dropped;
  out.serial_refused = report.serial_refused;
  return out;
}

stof_health with_age(stof_health health, const client::LinkState& state) noexcept {
  const client::Duration age = state.health_age.value_or(client::Duration(0));
  health.age_ns = std::chrono::nanoseconds(age).count();
  health.silent = state.silent ? 1 : 0;
  return health;
}

std::int64_t here_ns(std::int64_t sensor_ns, const client::ClockMapping& mapping) noexcept {
  // Any bytes may have been a stamp.
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(sensor_ns) +
                                   static_cast<std::uint64_t>(mapping.offset_ns));
}

stof_link to_link(const client::LinkState& state) noexcept {
  const auto age_ns = [](const std::optional<client::Duration>& age) {
    return age ? std::chrono::nanoseconds(*age).count() : -1;
  };
  stof_link out{};
  out.conditions =
      (state.silent ? STOF_LINK_SILENT : 0U) | (state.restarted ? STOF_LINK_RESTARTED : 0U) |
      (state.forged_traffic ? STOF_LINK_FORGED : 0U) | (state.delayed ? STOF_LINK_DELAYED : 0U) |
      (state.no_key ? STOF_LINK_NO_KEY : 0U);
  out.frame_age_ns = age_ns(state.frame_age);
  out.health_age_ns = age_ns(state.health_age);
  out.calibration_age_ns = age_ns(state.calibration_age);
  return out;
}

stof_link_event to_link_event(const client::LinkEvent& event) noexcept {
  stof_link_event out{};
  out.condition = 1U << static_cast<unsigned>(event.condition);
  out.active = event.active ? 1 : 0;
  out.count = event.count;
  out.at_ns = since_boot_ns(event.at);
  return out;
}

stof_raw to_raw(const client::RawExposure& exposure) noexcept {
  const wire::RawInfo& info = exposure.info;
  stof_raw out{};
  out.device_id = exposure.origin.device_id;
  out.session_id = exposure.origin.session_id;
  out.frame_number = exposure.stamp.number;
  out.freshness = exposure.stamp.freshness;
  out.number = info.number;
  out.dropped = info.dropped;
  out.pictures = info.pictures;
  out.missing = exposure.missing;
  out.edge_ns = info.edge_ns;
  out.exposure_middle_ns = exposure.stamp.exposure_middle_ns;
  out.column = info.column;
  out.row = info.row;
  out.step = info.step;
  out.camera_width = info.camera_width;
  out.camera_height = info.camera_height;
  out.state = info.state;
  out.pmd_every = info.pmd_every;
  out.left = to_whole_plane(exposure.left);
  out.right = to_whole_plane(exposure.right);
  for (std::size_t sample = 0; sample < exposure.pmd.size(); ++sample) {
    out.pmd[sample] = to_whole_plane(exposure.pmd[sample]);
  }
  return out;
}

stof_event to_event(const wire::EventReport& report) noexcept {
  stof_event out{};
  out.sequence = report.sequence;
  out.condition = report.condition;
  out.severity = static_cast<std::uint32_t>(report.severity);
  out.reaction = static_cast<std::uint32_t>(report.reaction);
  out.active = report.active;
  out.count = report.count;
  out.value = report.value;
  out.at_ns = report.at_ns;
  return out;
}

stof_statistics to_statistics(const client::Statistics& statistics, int socket_buffer) noexcept {
  stof_statistics out{};
  out.socket_buffer = static_cast<std::uint32_t>(std::max(socket_buffer, 0));
  out.packets = statistics.packets();
  out.packets_ok = statistics.packets_ok;
  out.packets_refused = statistics.truncated + statistics.bad_magic + statistics.bad_version +
                        statistics.bad_length + statistics.bad_crc + statistics.bad_field +
                        statistics.oversized;
  out.packets_unknown = statistics.unknown;
  out.packets_foreign = statistics.foreign;
  out.packets_duplicate = statistics.duplicate;
  out.packets_late = statistics.late;
  out.packets_missing = statistics.packets_missing;
  out.packets_recovered = statistics.recovered;
  out.frames_complete = statistics.frames_complete;
  out.frames_incomplete = statistics.frames_incomplete;
  out.frames_stale = statistics.frames_stale;
  out.frames_lost = statistics.frames_lost;
  out.frames_dropped = statistics.frames_dropped;
  out.sessions = statistics.sessions;
  out.socket_drops = statistics.socket_drops;
  out.packets_old = statistics.old;
  out.packets_implausible = statistics.implausible;
  out.frames_old = statistics.frames_old;
  out.resynchronised = statistics.resynchronised;
  out.packets_not_signed = statistics.not_signed;
  out.packets_forged = statistics.forged;
  return out;
}

}  // namespace stof::lib

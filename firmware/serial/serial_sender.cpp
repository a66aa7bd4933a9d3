#include "firmware/serial/serial_sender.h"

#include <algorithm>
#include <array>

#include "dsp/base/check.h"
#include "dsp/fusion/decimate.h"
#include "hal/framing/cobs.h"

namespace stof::firmware {
namespace {

using settings::SerialMode;
using settings::SerialProfile;

constexpr hal::Duration kSecond = std::chrono::seconds(1);
constexpr wire::FrameSizes kLargest{.width = kMedium.width, .height = kMedium.height};
// Depth and width, raw, and the frame info.
constexpr std::size_t kMostPackets =
    1 + 2 * wire::raw_tiles(kMedium.width, kMedium.height, sizeof(dsp::QuarterMm));

dsp::Pinhole lens_of(const wire::CalibrationPacket& calibration) noexcept {
  constexpr double kOne = 65'536;
  return {.width = calibration.image_width,
          .height = calibration.image_height,
          .fx = calibration.fx / kOne,
          .fy = calibration.fy / kOne,
          .cx = calibration.cx / kOne,
          .cy = calibration.cy / kOne};
}

mavlink::State state_of(wire::Health health) noexcept {
  switch (health) {
    case wire::Health::kOk:
      return mavlink::State::kActive;
    case wire::Health::kDegraded:
      return mavlink::State::kCritical;
    default:
      return mavlink::State::kEmergency;
  }
}

// Rounded up; what is surer than a centimetre is told as one.
std::uint8_t variance_cm2(std::uint32_t sigma_mm) noexcept {
  constexpr std::uint64_t kMm2PerCm2 = 100;
  const std::uint64_t variance = (std::uint64_t{sigma_mm} * sigma_mm + kMm2PerCm2 - 1) / kMm2PerCm2;
  return static_cast<std::uint8_t>(
      std::clamp<std::uint64_t>(variance, 1, mavlink::kUnknownVariance));
}

}  // namespace

SerialSender::SerialSender(const SerialSetup& setup, ByteRing& ring, dsp::Arena& arena) noexcept
    : setup_(setup),
      ring_(ring),
      finder_(lens_of(setup.calibration), SectorParams{}, arena),
      coder_(setup.origin, kLargest, setup.calibration, arena, kMostPackets),
      picture_{.depth = arena.take_image<dsp::QuarterMm>(kMedium.width, kMedium.height),
               .width = arena.take_image<dsp::QuarterMm>(kMedium.width, kMedium.height),
               .source = {}},
      mavlink_(params_.system_id, params_.component_id) {}

void SerialSender::set(const SerialParams& params) noexcept {
  if (params == params_) {
    return;
  }
  params_ = params;
  params_.baud = std::max(params.baud, 1U);
  params_.rate_hz = std::max(params.rate_hz, 1U);
  budget_.set_baud(params_.baud);
  finder_.set(params_.sectors);
  mavlink_.name(params_.system_id, params_.component_id);
  next_ = {};
  next_calibration_ = {};
}

void SerialSender::set_calibration(const wire::CalibrationPacket& calibration) noexcept {
  setup_.calibration = calibration;
  finder_.set_lens(lens_of(calibration));
  coder_.set_calibration(calibration);
  next_calibration_ = {};
}

hal::Duration SerialSender::interval() const noexcept { return kSecond / params_.rate_hz; }

bool SerialSender::due(hal::Time now) noexcept {
  if (!next_) {
    next_ = now;
  }
  if (now < *next_) {
    return false;
  }
  const hal::Duration::rep missed = (now - *next_) / interval();
  if (blocked_) {
    counters_.dropped += static_cast<std::uint64_t>(missed);
  }
  *next_ += missed * interval();
  return true;
}

void SerialSender::frame(const wire::FrameStamp& stamp, const wire::FrameInfo& info,
                         const dsp::DepthMap& map, hal::Time now) noexcept {
  if (params_.mode == SerialMode::kOff || !due(now)) {
    return;
  }
  blocked_ = budget_.backlog(now) > interval() / 2;
  if (blocked_) {
    return;
  }
  const bool picture =
      params_.mode == SerialMode::kStof && params_.profile != SerialProfile::kSectors;
  wire::FrameStamp own = stamp;
  own.number = number_;
  if (picture) {
    blocked_ = !send_picture(own, info, map, now);
  } else {
    const Sectors& sectors = finder_.find(map);
    blocked_ = !(params_.mode == SerialMode::kMavlink ? send_mavlink(sectors, own, now)
                                                      : send_sectors(sectors, own, now));
  }
  if (!blocked_) {
    ++number_;
    *next_ += interval();
  }
}

bool SerialSender::send_picture(const wire::FrameStamp& stamp, const wire::FrameInfo& info,
                                const dsp::DepthMap& map, hal::Time now) noexcept {
  const PictureProfile& profile = params_.profile == SerialProfile::kCoarse ? kCoarse : kMedium;
  const int step = profile_step(profile, map.depth.width(), map.depth.height());
  if (step > dsp::kMostBlock) {
    return false;
  }
  const int columns = dsp::decimated(map.depth.width(), step);
  const int rows = dsp::decimated(map.depth.height(), step);
  const dsp::DepthMap small{.depth = dsp::cut(picture_.depth, columns, rows),
                            .width = dsp::cut(picture_.width, columns, rows),
                            .source = {}};
  dsp::decimate(map, step, small.depth, small.width);
  coarsen(profile.unit, small.depth, small.width);
  wire::StreamChoice choice;
  choice.of(wire::Stream::kDepth) = wire::Coding::kRvl;
  choice.of(wire::Stream::kWidth) = params_.width ? wire::Coding::kRvl : wire::Coding::kOff;
  const Result<Records> packets = coder_.code(
      stamp, info, {.map = small, .disparity = {}, .pmd = {}, .left = {}, .right = {}}, choice);
  if (!packets || !push(*packets, now)) {
    return false;
  }
  if (!next_calibration_ || now >= *next_calibration_) {
    next_calibration_ = send_calibration(stamp, info, profile, now) ? now + kSecond : now;
  }
  return true;
}

bool SerialSender::send_calibration(const wire::FrameStamp& stamp, const wire::FrameInfo& info,
                                    const PictureProfile& profile, hal::Time now) noexcept {
  wire::CalibrationPacket whole = setup_.calibration;
  if (info.period_ns > 0) {  // settings change both
    whole.max_range = info.max_range_um / whole.depth_unit_um;
    whole.period_ns = info.period_ns;
  }
  const wire::CalibrationPacket calibration = profile_calibration(whole, profile);
  wire::encode_calibration_packet(
      calibration, wire::payload_space(packet_).first<wire::kCalibrationPacketBytes>());
  const std::array records{wire::seal_packet({.type = wire::PacketType::kCalibration,
                                              .origin = setup_.origin,
                                              .frame = stamp,
                                              .image_width = calibration.image_width,
                                              .image_height = calibration.image_height},
                                             wire::kCalibrationPacketBytes, packet_)};
  return push(records, now);
}

bool SerialSender::send_sectors(const Sectors& sectors, const wire::FrameStamp& stamp,
                                hal::Time now) noexcept {
  wire::encode_sector_report(sectors.report,
                             wire::payload_space(packet_).first<wire::kSectorReportBytes>());
  const std::array records{wire::seal_packet({.type = wire::PacketType::kSectors,
                                              .origin = setup_.origin,
                                              .frame = stamp,
                                              .image_width = setup_.calibration.image_width,
                                              .image_height = setup_.calibration.image_height},
                                             wire::kSectorReportBytes, packet_)};
  return push(records, now);
}

bool SerialSender::send_mavlink(const Sectors& sectors, const wire::FrameStamp& stamp,
                                hal::Time now) noexcept {
  constexpr float kDegreesPerMicro = 1e-6F;
  constexpr std::int64_t kNsPerUs = 1000;
  constexpr std::int64_t kNsPerMs = 1'000'000;
  constexpr std::uint8_t kGood = 100;  // percent
  constexpr std::uint8_t kInvalid = 1;
  const wire::SectorReport& report = sectors.report;
  const bool known = sectors.ahead_cm != kUnknownSector;
  mavlink::Buffer first{};
  mavlink::Buffer second{};
  const std::array records{
      mavlink_.write(
          mavlink::ObstacleDistance{
              .time_us = static_cast<std::uint64_t>(stamp.exposure_middle_ns / kNsPerUs),
              .distances_cm = report.distances_cm,
              .least_cm = report.least_cm,
              .most_cm = report.most_cm,
              .increment_deg = static_cast<float>(report.step_udeg) * kDegreesPerMicro,
              .angle_offset_deg = static_cast<float>(report.first_udeg) * kDegreesPerMicro},
          first),
      // An invalid reading is told as nearer than the least: whoever does not look at the quality
      // stops rather than goes on.
      mavlink_.write(
          mavlink::DistanceSensor{
              .time_boot_ms = static_cast<std::uint32_t>(stamp.exposure_middle_ns / kNsPerMs),
              .least_cm = report.least_cm,
              .most_cm = report.most_cm,
              .distance_cm = known ? sectors.ahead_cm : std::uint16_t{0},
              .variance_cm2 =
                  known ? variance_cm2(sectors.ahead_sigma_mm) : mavlink::kUnknownVariance,
              .horizontal_fov_rad = finder_.ahead_field_rad(),
              .vertical_fov_rad = finder_.vertical_field_rad(),
              .quality = known ? kGood : kInvalid},
          second)};
  return push(records, now);
}

void SerialSender::tick(hal::Time now, wire::Health health) noexcept {
  if (params_.mode != SerialMode::kMavlink || (next_heartbeat_ && now < *next_heartbeat_)) {
    return;
  }
  next_heartbeat_ = now + kSecond;
  mavlink::Buffer buffer{};
  const std::array records{mavlink_.write(mavlink::Heartbeat{.state = state_of(health)}, buffer)};
  counters_.dropped += push(records, now) ? 0U : 1U;
}

void SerialSender::put(std::span<const std::byte> packet, hal::Time now) noexcept {
  if (params_.mode == SerialMode::kStof) {
    const std::array records{packet};
    counters_.dropped += push(records, now) ? 0U : 1U;
  }
}

bool SerialSender::push(Records records, hal::Time now) noexcept {
  std::size_t cost = 0;
  std::size_t on_line = 0;
  for (const std::span<const std::byte> record : records) {
    cost += ByteRing::cost(record.size());
    on_line +=
        params_.mode == SerialMode::kStof ? hal::cobs_bound(record.size()) + 1 : record.size();
  }
  if (cost > ring_.room()) {
    return false;
  }
  for (const std::span<const std::byte> record : records) {
    ring_.put(record);
  }
  ring_.publish();
  budget_.spend(on_line, now);
  ++counters_.sent;
  return true;
}

}  // namespace stof::firmware

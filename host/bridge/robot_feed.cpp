#include "host/bridge/robot_feed.h"

#include <array>

#include "host/bridge/block_cloud.h"
#include "host/recording/frame_messages.h"

namespace stof::bridge {
namespace {

// A frame goes with the calibration that it was made with and no other one.
bool goes_with_calibration(const client::Frame& frame) {
  if (!frame.calibration) {
    return false;
  }
  const std::uint32_t made_with = frame.info ? frame.info->calibration_fingerprint : 0;
  const std::uint32_t known = frame.calibration->fingerprint;
  return made_with == 0 || known == 0 || made_with == known;
}

std::string clock_name(wire::ClockState clock) {
  switch (clock) {
    case wire::ClockState::kMonotonic:
      return "free";
    case wire::ClockState::kEmulated:
      return "emulated";
    case wire::ClockState::kRecorded:
      return "recorded";
  }
  return "of a newer sensor";
}

}  // namespace

RobotFeed::RobotFeed(TopicSink& sink, FeedOptions options)
    : sink_(sink), options_(std::move(options)), frames_(frame_ids(options_.name_space)) {}

void RobotFeed::publish(Topic topic, recording::Buffer&& message) {
  refused_ += sink_.publish(topic, std::move(message)) ? 0U : 1U;
}

std::int64_t RobotFeed::show(const client::Frame& frame, const Times& times) {
  const ExposureClock::Exposure exposure =
      clock_.note({.session = frame.origin.session_id,
                   .stamp = frame.stamp,
                   .latency_ns = frame.info ? std::optional(frame.info->latency_ns) : std::nullopt,
                   .at_ns = times.first_packet_ns,
                   .round_trip_ns = times.round_trip_ns});
  const recording::MessageHeader header{.stamp_ns = exposure.middle_ns + times.wall_offset_ns,
                                        .frame_id = frames_.optical};
  origin_ = frame.origin;
  newest_ = frame.stamp;
  bound_ns_ = exposure.bound_ns;
  ++shown_;
  if (frame.depth.empty()) {
    return header.stamp_ns;
  }
  if (sink_.wanted(Topic::kDepth)) {
    publish(Topic::kDepth, recording::encode_depth_mm(header, frame));
  }
  if (!goes_with_calibration(frame)) {
    ++without_calibration_;
    return header.stamp_ns;
  }
  if (sink_.wanted(Topic::kCameraInfo)) {
    publish(Topic::kCameraInfo, recording::encode_camera_info(header, *frame.calibration));
  }
  if (options_.cloud_step > 0 && sink_.wanted(Topic::kPoints) &&
      block_cloud(frame, options_.cloud_step, points_) == Status::kOk) {
    publish(Topic::kPoints, recording::encode_point_cloud(header, points_));
  }
  return header.stamp_ns;
}

recording::DiagnosticStatus RobotFeed::link_status(const Link& link) const {
  using Level = recording::DiagnosticLevel;
  const client::Statistics& all = link.statistics;
  const bool replayed =
      link.recording || (newest_ && newest_->clock == wire::ClockState::kRecorded);
  recording::DiagnosticStatus status{
      .level = replayed ? Level::kWarn : Level::kOk,
      .name = options_.name_space + ": link",
      .message = replayed ? "REPLAY: nothing of it is new" : "frames come",
      .hardware_id = std::to_string(origin_.device_id)};
  if (!link.trouble.empty()) {
    status.level = Level::kStale;
    status.message = link.trouble;
  }
  constexpr std::int64_t kMicrosecond = 1000;
  status.values = {
      {"sensor", link.place},
      {"session", std::to_string(origin_.session_id)},
      {"sensor_clock", newest_ ? clock_name(newest_->clock) : "not known"},
      {"stamp_bound_us", bound_ns_ ? std::to_string(*bound_ns_ / kMicrosecond) : "not known"},
      {"frames", std::to_string(shown_)},
      {"frames_incomplete", std::to_string(all.frames_incomplete)},
      {"frames_lost", std::to_string(all.frames_lost)},
      {"frames_old", std::to_string(all.frames_old + all.frames_stale)},
      {"packets_missing", std::to_string(all.packets_missing)},
      {"frames_without_calibration", std::to_string(without_calibration_)},
      {"messages_refused", std::to_string(refused_)}};
  return status;
}

void RobotFeed::tell(const Link& link, std::int64_t wall_ns) {
  recording::DiagnosticStatus health;
  const std::string name = options_.name_space + ": health";
  if (link.health) {
    health = recording::health_status(name, origin_.device_id, *link.health);
  } else {
    health = {.level = recording::DiagnosticLevel::kStale,
              .name = name,
              .message = "the sensor says nothing",
              .hardware_id = std::to_string(origin_.device_id)};
  }
  const std::array statuses{health, link_status(link)};
  publish(Topic::kDiagnostics,
          recording::encode_diagnostics({.stamp_ns = wall_ns, .frame_id = ""}, statuses));
}

void RobotFeed::place_frames(std::int64_t wall_ns) {
  publish(Topic::kTransforms, static_transforms(frames_, options_.mount, wall_ns));
}

}  // namespace stof::bridge

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "host/recording/mcap/records.h"
#include "host/recording/ros_messages.h"

// The channels of a recording. docs/RECORDING.md says what is in each.
namespace stof::recording {

enum class Topic : std::uint8_t {
  kDepthMm,
  kCameraInfo,
  kDiagnostics,
  kDepth,
  kWidth,
  kSource,
  kReceived,
  kDisparity,
  kPmdRaw,
  kLeft,
  kRight,
  kFrameInfo,
  kCalibration,
  kHealth,
  kEvent,
  kSettings,
  kRawEdge,
  kRawLeft,
  kRawRight,
  kRawPmd,
};
inline constexpr std::size_t kTopics = 20;

struct TopicInfo {
  std::string_view name;
  mcap::Schema (*schema)();
  std::string_view unit;  // of a pixel, in the channel's metadata; empty: none
};

inline constexpr std::array<TopicInfo, kTopics> kTopicInfos{{
    {"/stof/depth/image_raw", image_schema, "1 mm, 0 none"},
    {"/stof/depth/camera_info", camera_info_schema, ""},
    {"/diagnostics", diagnostics_schema, ""},
    {"/stof/depth/exact", image_schema, "depth units of the calibration (0.25 mm), 0 none"},
    {"/stof/depth/width", image_schema, "depth units of the calibration (0.25 mm)"},
    {"/stof/depth/source", image_schema, "source in bits 0 to 3, cause in bits 4 to 7"},
    {"/stof/depth/received", image_schema, "bit 0 depth, 1 width, 2 source arrived"},
    {"/stof/disparity", image_schema, "32768 + disparity in 1/16 px, 0 none"},
    {"/stof/pmd/raw", image_schema, "samples A0 to A3 below each other"},
    {"/stof/left/image_rect", image_schema, "grey value"},
    {"/stof/right/image_rect", image_schema, "grey value"},
    {"/stof/frame_info", packet_schema, ""},
    {"/stof/calibration", packet_schema, ""},
    {"/stof/health", packet_schema, ""},
    {"/stof/event", packet_schema, ""},
    {"/stof/settings", string_schema, ""},
    {"/stof/raw/edge", packet_schema, ""},
    {"/stof/raw/left", image_schema, "grey value"},
    {"/stof/raw/right", image_schema, "grey value"},
    {"/stof/raw/pmd", image_schema, "samples A0 to A3 below each other"},
}};

constexpr const TopicInfo& info_of(Topic topic) noexcept {
  return kTopicInfos[static_cast<std::size_t>(topic)];
}
constexpr std::optional<Topic> topic_named(std::string_view name) noexcept {
  for (std::size_t k = 0; k < kTopics; ++k) {
    if (kTopicInfos[k].name == name) {
      return static_cast<Topic>(k);
    }
  }
  return std::nullopt;
}

inline constexpr std::string_view kProfile = "ros2";
inline constexpr std::string_view kEncoding = "cdr";
inline constexpr const char* kSensorMetadata = "stof";
// In it: how often it was told that somebody speaks in the sensor's name.
inline constexpr const char* kForgedTraffic = "forged_traffic";
inline constexpr const char* kSettingsAttachment = "settings.json";
inline constexpr const char* kCalibrationAttachment = "calibration.cal";

}  // namespace stof::recording

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/recording/ros_messages.h"

// What the bridge publishes. docs/ROBOT.md, "ROS 2".
namespace stof::bridge {

enum class Topic : std::uint8_t { kDepth, kCameraInfo, kPoints, kDiagnostics, kTransforms };
inline constexpr std::size_t kTopics = 5;

struct TopicInfo {
  std::string_view name;  // within the sensor's namespace; with a slash before it, in none
  mcap::Schema (*schema)();
  int depth;     // of KEEP_LAST
  bool latched;  // transient local: who comes later gets the newest
};

inline constexpr std::array<TopicInfo, kTopics> kTopicInfos{{
    {"depth/image_raw", recording::image_schema, 2, false},
    {"depth/camera_info", recording::camera_info_schema, 2, false},
    {"depth/points", recording::point_cloud_schema, 2, false},
    {"/diagnostics", recording::diagnostics_schema, 10, false},
    {"/tf_static", recording::transforms_schema, 1, true},
}};

constexpr const TopicInfo& info_of(Topic topic) noexcept {
  return kTopicInfos[static_cast<std::size_t>(topic)];
}

// "rt/front/depth/image_raw", "rt/diagnostics": what ROS 2 calls "/front/depth/image_raw" to DDS.
inline std::string dds_topic_name(Topic topic, const std::string& name_space) {
  const std::string_view name = info_of(topic).name;
  return name.starts_with('/') ? "rt" + std::string(name)
                               : "rt/" + name_space + "/" + std::string(name);
}

// Whether it is the name of a namespace in ROS: words of letters, digits and _ that begin with no
// digit, with slashes between them.
bool good_namespace(std::string_view name) noexcept;

// The frames of one sensor by REP 103 and 105. `link` is its body: x ahead, y left, z up; `optical`
// the rectified left camera: x right, y down, z ahead. Both have the same origin.
struct FrameIds {
  std::string link{};
  std::string optical{};
};
FrameIds frame_ids(std::string_view name_space);

// Where the sensor is on the robot.
struct Mount {
  std::string parent{};  // frame; empty: not told
  std::array<double, 3> translation_m{};
  std::array<double, 3> roll_pitch_yaw{};  // radians, about the parent's fixed axes x, y, z
};

// What /tf_static holds.
recording::Buffer static_transforms(const FrameIds& frames, const Mount& mount,
                                    std::int64_t stamp_ns);

}  // namespace stof::bridge

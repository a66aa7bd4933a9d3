#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <builtin_interfaces/msg/time.hpp>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <stof/stof.hpp>

// A frame of libstof as messages of ROS 2. No node, no clock, no state; headers are the caller's.
// What they hold is what `stof bridge ros2` publishes: docs/ROBOT.md, "ROS 2".
namespace stof_driver {

constexpr int kMostCloudStep = 64;

builtin_interfaces::msg::Time time_of(std::int64_t ns);

// By this machine's CLOCK_MONOTONIC: the middle of the exposure as libstof maps it. Where it cannot
// (an emulated clock, a recording, no frame before) the arrival less what the sensor says that it
// took until it sent: too late by the first packet's way.
std::int64_t exposure_here_ns(const stof::Frame& frame);

// Depth Z, 16UC1, millimetres rounded half up; 0: unknown, never free. False: the frame has none.
bool fill_image(const stof::Frame& frame, sensor_msgs::msg::Image& image);

// The rectified left camera, no distortion. False: the frame has no calibration.
bool fill_camera_info(const stof::Frame& frame, sensor_msgs::msg::CameraInfo& info);

// Of each block of step x step pixels the point whose near bound, depth - width / 2, is nearest:
// float32 x y z z_width, metres; z_width -1: not known. step: 1 to kMostCloudStep. False: the frame
// has no depth, or no calibration of its size.
bool fill_cloud(const stof::Frame& frame, int step, sensor_msgs::msg::PointCloud2& cloud);

// What the sensor says of itself; STALE where nothing of it came for two and a half seconds.
diagnostic_msgs::msg::DiagnosticStatus health_status(const std::string& name,
                                                     const std::string& hardware_id,
                                                     const std::optional<stof::Health>& health);

}  // namespace stof_driver

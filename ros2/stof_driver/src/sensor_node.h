#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <stof/stof.hpp>
#include <tf2_ros/static_transform_broadcaster.h>

namespace stof_driver {

// One sensor as a component: depth/image_raw, depth/camera_info and depth/points in the node's
// namespace, /diagnostics, and the static transform to the optical frame. Parameters, read once, at
// the start: sensor (HOST[:PORT]), keys (file; empty: this user's), signed_streams, cloud_step
// (pixels; 0: no cloud), frame_prefix (empty: the namespace with _ for /, else "stof").
// A thread of its own receives, and opens the socket anew when it fails. Silence publishes no
// frame: diagnostics say STALE. std::invalid_argument: a parameter is wrong; what() is one line.
class SensorNode : public rclcpp::Node {
 public:
  explicit SensorNode(const rclcpp::NodeOptions& options);
  SensorNode(const SensorNode&) = delete;
  SensorNode& operator=(const SensorNode&) = delete;
  ~SensorNode() override;

 private:
  void run();
  void receive(stof::Sensor& sensor);
  void show(const stof::Frame& frame);
  // The state once a second, and when frames stop or come again. `trouble`: why none come.
  void tell(const std::string& trouble, const std::optional<stof::Health>& health);
  void place_frames();

  template <typename Message>
  using Writer = typename rclcpp::Publisher<Message>::SharedPtr;

  std::string sensor_{};
  std::string keys_{};
  bool signed_streams_ = false;
  int cloud_step_ = 0;
  std::string prefix_{};
  std::string trouble_{};
  std::optional<std::chrono::steady_clock::time_point> told_{};
  std::uint64_t frames_ = 0;
  std::uint64_t incomplete_ = 0;
  Writer<sensor_msgs::msg::Image> image_{};
  Writer<sensor_msgs::msg::CameraInfo> info_{};
  Writer<sensor_msgs::msg::PointCloud2> cloud_{};
  Writer<diagnostic_msgs::msg::DiagnosticArray> diagnostics_{};
  std::unique_ptr<tf2_ros::StaticTransformBroadcaster> transforms_{};
  std::atomic<bool> ending_{false};
  std::thread thread_{};  // last: it uses all of them
};

}  // namespace stof_driver

#include "sensor_node.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <diagnostic_msgs/msg/key_value.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <rclcpp_components/register_node_macro.hpp>

#include "messages.h"

namespace stof_driver {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLook{100};      // how late it sees that it is to end
constexpr milliseconds kRetry{1000};    // after a socket that could not be opened
constexpr milliseconds kTelling{1000};  // of diagnostics

template <typename Clock>
std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
      .count();
}

std::string prefix_of(std::string name_space) {
  name_space.erase(0, name_space.find_first_not_of('/'));
  std::replace(name_space.begin(), name_space.end(), '/', '_');
  return name_space.empty() ? "stof" : name_space;
}

diagnostic_msgs::msg::KeyValue key_value(const std::string& key, const std::string& value) {
  diagnostic_msgs::msg::KeyValue pair;
  pair.key = key;
  pair.value = value;
  return pair;
}

}  // namespace

SensorNode::SensorNode(const rclcpp::NodeOptions& options) : rclcpp::Node("stof", options) {
  sensor_ = declare_parameter<std::string>("sensor", "");
  keys_ = declare_parameter<std::string>("keys", "");
  signed_streams_ = declare_parameter<bool>("signed_streams", false);
  const std::int64_t step = declare_parameter<std::int64_t>("cloud_step", 4);
  prefix_ = declare_parameter<std::string>("frame_prefix", "");
  if (sensor_.empty()) {
    throw std::invalid_argument("parameter sensor is empty: give HOST[:PORT] (stof discover)");
  }
  if (step < 0 || step > kMostCloudStep) {
    throw std::invalid_argument("parameter cloud_step is " + std::to_string(step) +
                                ": give 0 (no cloud) to " + std::to_string(kMostCloudStep));
  }
  cloud_step_ = static_cast<int>(step);
  if (prefix_.empty()) {
    prefix_ = prefix_of(get_namespace());
  }
  // Reliable writers serve readers that ask for best effort as well.
  const rclcpp::QoS of_frames = rclcpp::QoS(rclcpp::KeepLast(2)).reliable();
  image_ = create_publisher<sensor_msgs::msg::Image>("depth/image_raw", of_frames);
  info_ = create_publisher<sensor_msgs::msg::CameraInfo>("depth/camera_info", of_frames);
  cloud_ = create_publisher<sensor_msgs::msg::PointCloud2>("depth/points", of_frames);
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>(
      "/diagnostics", rclcpp::QoS(rclcpp::KeepLast(10)).reliable());
  transforms_ = std::make_unique<tf2_ros::StaticTransformBroadcaster>(this);
  place_frames();
  thread_ = std::thread([this] { run(); });
}

SensorNode::~SensorNode() {
  ending_ = true;
  thread_.join();
}

void SensorNode::place_frames() {
  geometry_msgs::msg::TransformStamped optical;
  optical.header.stamp = time_of(now_ns<std::chrono::system_clock>());
  optical.header.frame_id = prefix_ + "_link";
  optical.child_frame_id = prefix_ + "_left_optical_frame";
  // From x ahead, y left, z up to x right, y down, z ahead.
  optical.transform.rotation.x = -0.5;
  optical.transform.rotation.y = 0.5;
  optical.transform.rotation.z = -0.5;
  optical.transform.rotation.w = 0.5;
  transforms_->sendTransform(optical);
}

void SensorNode::run() {
  while (!ending_) {
    stof::Options options = STOF_INIT(stof_options);
    options.sensor = sensor_.c_str();
    options.keys = keys_.empty() ? nullptr : keys_.c_str();
    options.signed_streams = signed_streams_ ? 1 : 0;
    std::string why;
    std::optional<stof::Sensor> sensor = stof::Sensor::open(options, &why);
    if (sensor) {
      receive(*sensor);
    } else {
      tell(why, std::nullopt);
    }
    for (milliseconds waited{0}; waited < kRetry && !ending_; waited += kLook) {
      std::this_thread::sleep_for(kLook);
    }
  }
}

void SensorNode::receive(stof::Sensor& sensor) {
  stof_status status = STOF_OK;
  while (!ending_ && (status == STOF_OK || status == STOF_TIMEOUT)) {
    if (const std::optional<stof::Frame> frame = sensor.next(kLook, &status)) {
      show(*frame);
    }
    const stof::Link link = sensor.link();
    std::string trouble;
    if (link.frame_age_ns < 0) {
      trouble = sensor_ + ": no frame so far";
    } else if ((link.conditions & STOF_LINK_SILENT) != 0) {
      trouble = sensor_ + ": no frame for " + std::to_string(link.frame_age_ns / 1'000'000) + " ms";
    }
    tell(trouble, sensor.health());
  }
}

void SensorNode::show(const stof::Frame& frame) {
  ++frames_;
  incomplete_ += frame.complete() ? 0 : 1;
  const std::int64_t to_system = now_ns<std::chrono::system_clock>() - now_ns<steady_clock>();
  std_msgs::msg::Header header;
  header.stamp = time_of(exposure_here_ns(frame) + to_system);
  header.frame_id = prefix_ + "_left_optical_frame";
  // Owned messages: a component beside this one gets them without a copy.
  if (image_->get_subscription_count() > 0) {
    auto image = std::make_unique<sensor_msgs::msg::Image>();
    image->header = header;
    if (fill_image(frame, *image)) {
      image_->publish(std::move(image));
    }
  }
  if (info_->get_subscription_count() > 0) {
    auto info = std::make_unique<sensor_msgs::msg::CameraInfo>();
    info->header = header;
    if (fill_camera_info(frame, *info)) {
      info_->publish(std::move(info));
    }
  }
  if (cloud_step_ > 0 && cloud_->get_subscription_count() > 0) {
    auto cloud = std::make_unique<sensor_msgs::msg::PointCloud2>();
    cloud->header = header;
    if (fill_cloud(frame, cloud_step_, *cloud)) {
      cloud_->publish(std::move(cloud));
    }
  }
}

void SensorNode::tell(const std::string& trouble, const std::optional<stof::Health>& health) {
  const steady_clock::time_point now = steady_clock::now();
  const bool changed = trouble.empty() != trouble_.empty();
  if (changed && trouble.empty()) {
    RCLCPP_INFO(get_logger(), "%s: frames come", sensor_.c_str());
  } else if (changed) {
    RCLCPP_WARN(get_logger(), "%s", trouble.c_str());
  }
  trouble_ = trouble;
  if (!changed && told_ && now - *told_ < kTelling) {
    return;
  }
  told_ = now;
  using Status = diagnostic_msgs::msg::DiagnosticStatus;
  Status link;
  link.name = prefix_ + ": link";
  link.hardware_id = sensor_;
  link.level = trouble.empty() ? Status::OK : Status::STALE;
  link.message = trouble.empty() ? "frames come" : trouble;
  link.values.push_back(key_value("frames", std::to_string(frames_)));
  link.values.push_back(key_value("frames_incomplete", std::to_string(incomplete_)));
  auto all = std::make_unique<diagnostic_msgs::msg::DiagnosticArray>();
  all->header.stamp = time_of(now_ns<std::chrono::system_clock>());
  all->status.push_back(health_status(prefix_ + ": health", sensor_, health));
  all->status.push_back(link);
  diagnostics_->publish(std::move(all));
}

}  // namespace stof_driver

RCLCPP_COMPONENTS_REGISTER_NODE(stof_driver::SensorNode)

#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

// As much of ROS 2's C++ interface as ros2/stof_driver takes, by its published documentation: the
// names, the fields and the signatures, nothing behind them. What is published stays in a Board,
// where a test reads it. It proves that the component is C++ and takes libstof as it is; nothing of
// ROS.
// NOLINTBEGIN(readability-identifier-naming, readability-convert-member-functions-to-static): as
// ROS has them.
namespace builtin_interfaces::msg {
struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
}  // namespace builtin_interfaces::msg

namespace std_msgs::msg {
struct Header {
  builtin_interfaces::msg::Time stamp{};
  std::string frame_id{};
};
}  // namespace std_msgs::msg

namespace sensor_msgs::msg {
struct Image {
  std_msgs::msg::Header header{};
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding{};
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data{};
};
struct CameraInfo {
  std_msgs::msg::Header header{};
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model{};
  std::vector<double> d{};
  std::array<double, 9> k{};
  std::array<double, 9> r{};
  std::array<double, 12> p{};
};
struct PointField {
  static constexpr std::uint8_t FLOAT32 = 7;
  std::string name{};
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
  std::uint32_t count = 0;
};
struct PointCloud2 {
  std_msgs::msg::Header header{};
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<PointField> fields{};
  bool is_bigendian = false;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  std::vector<std::uint8_t> data{};
  bool is_dense = false;
};
}  // namespace sensor_msgs::msg

namespace diagnostic_msgs::msg {
struct KeyValue {
  std::string key{};
  std::string value{};
};
struct DiagnosticStatus {
  static constexpr unsigned char OK = 0;
  static constexpr unsigned char WARN = 1;
  static constexpr unsigned char ERROR = 2;
  static constexpr unsigned char STALE = 3;
  unsigned char level = 0;
  std::string name{};
  std::string message{};
  std::string hardware_id{};
  std::vector<KeyValue> values{};
};
struct DiagnosticArray {
  std_msgs::msg::Header header{};
  std::vector<DiagnosticStatus> status{};
};
}  // namespace diagnostic_msgs::msg

namespace geometry_msgs::msg {
struct Vector3 {
  double x = 0;
  double y = 0;
  double z = 0;
};
struct Quaternion {
  double x = 0;
  double y = 0;
  double z = 0;
  double w = 1;
};
struct Transform {
  Vector3 translation{};
  Quaternion rotation{};
};
struct TransformStamped {
  std_msgs::msg::Header header{};
  std::string child_frame_id{};
  Transform transform{};
};
}  // namespace geometry_msgs::msg

namespace ros_standin {

// The newest message of each topic of one type, and how many there were. From any thread.
template <typename Message>
class Board {
 public:
  static Board& get() {
    static Board board;
    return board;
  }
  void put(const std::string& topic, const Message& message) {
    {
      const std::scoped_lock lock(mutex_);
      newest_[topic] = message;
      ++count_[topic];
    }
    changed_.notify_all();
  }
  // Waits for `seconds` at most until `good` is true of the newest one of a topic.
  bool await(const std::string& topic, int seconds,
             const std::function<bool(const Message&)>& good) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(seconds),
                             [&] { return count_[topic] > 0 && good(newest_[topic]); });
  }
  Message newest(const std::string& topic) {
    const std::scoped_lock lock(mutex_);
    return newest_[topic];
  }
  int count(const std::string& topic) {
    const std::scoped_lock lock(mutex_);
    return count_[topic];
  }

 private:
  std::mutex mutex_{};
  std::condition_variable changed_{};
  std::map<std::string, Message> newest_{};
  std::map<std::string, int> count_{};
};

}  // namespace ros_standin

namespace rclcpp {

struct KeepLast {
  explicit KeepLast(std::size_t messages) : depth(messages) {}
  std::size_t depth;
};
class QoS {
 public:
  QoS(const KeepLast& history) : depth_(history.depth) {}  // NOLINT: as ROS has it
  QoS& reliable() { return *this; }
  std::size_t depth() const { return depth_; }

 private:
  std::size_t depth_;
};

class NodeOptions {
 public:
  template <typename Value>
  NodeOptions& append_parameter_override(const std::string& name, const Value& value) {
    if constexpr (std::is_same_v<Value, bool>) {
      flags_[name] = value;
    } else if constexpr (std::is_integral_v<Value>) {
      integers_[name] = value;
    } else {
      texts_[name] = value;
    }
    return *this;
  }
  bool find(const std::string& name, bool other) const { return find_in(flags_, name, other); }
  std::int64_t find(const std::string& name, std::int64_t other) const {
    return find_in(integers_, name, other);
  }
  std::string find(const std::string& name, const std::string& other) const {
    return find_in(texts_, name, other);
  }
  std::string name_space{};  // the stand-in's: --ros-args -r __ns:= in ROS

 private:
  template <typename Value>
  static Value find_in(const std::map<std::string, Value>& all, const std::string& name,
                       const Value& other) {
    const auto found = all.find(name);
    return found == all.end() ? other : found->second;
  }
  std::map<std::string, bool> flags_{};
  std::map<std::string, std::int64_t> integers_{};
  std::map<std::string, std::string> texts_{};
};

template <typename Message>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher>;
  explicit Publisher(std::string topic) : topic_(std::move(topic)) {}
  void publish(std::unique_ptr<Message> message) {
    ros_standin::Board<Message>::get().put(topic_, *message);
  }
  std::size_t get_subscription_count() const { return 1; }

 private:
  std::string topic_;
};

struct Logger {
  std::string name{};
};

class Node {
 public:
  Node(std::string name, NodeOptions options)
      : name_(std::move(name)), options_(std::move(options)) {}
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual ~Node() = default;

  template <typename Value>
  Value declare_parameter(const std::string& name, const Value& value) {
    return options_.find(name, value);
  }
  template <typename Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic,
                                                          const QoS& /*qos*/) {
    return std::make_shared<Publisher<Message>>(
        topic[0] == '/' ? topic : options_.name_space + "/" + topic);
  }
  const char* get_namespace() const { return options_.name_space.c_str(); }
  Logger get_logger() const { return {name_}; }

 private:
  std::string name_;
  NodeOptions options_;
};

}  // namespace rclcpp

namespace tf2_ros {
class StaticTransformBroadcaster {
 public:
  explicit StaticTransformBroadcaster(rclcpp::Node* /*node*/) {}
  void sendTransform(const geometry_msgs::msg::TransformStamped& transform) {
    ros_standin::Board<geometry_msgs::msg::TransformStamped>::get().put("/tf_static", transform);
  }
};
}  // namespace tf2_ros

#define RCLCPP_INFO(logger, ...) \
  (static_cast<void>(logger), std::printf(__VA_ARGS__), std::puts(""))
#define RCLCPP_WARN(logger, ...) RCLCPP_INFO(logger, __VA_ARGS__)
// In ROS: makes the class known to whoever loads the library. Here: that there is such a
// constructor.
#define RCLCPP_COMPONENTS_REGISTER_NODE(Class) \
  static_assert(std::is_constructible_v<Class, const rclcpp::NodeOptions&>);
// NOLINTEND(readability-identifier-naming, readability-convert-member-functions-to-static)

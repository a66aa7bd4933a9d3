// driver_on_standin HOST:PORT: the component of ros2/stof_driver, with a sensor and without ROS.
// Says what is wrong, and ends with 1. Waits for `gone` on its standard input: then the sensor is
// away, and diagnostics have to say so.
#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <string>

#include "ros2/stof_driver/src/sensor_node.h"

namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::PointCloud2;

constexpr int kSeconds = 60;
int wrong = 0;

void expect(bool good, const char* what) {
  if (!good) {
    std::printf("wrong: %s\n", what);
    ++wrong;
  }
}

bool refused(const rclcpp::NodeOptions& options) {
  try {
    const stof_driver::SensorNode node(options);
  } catch (const std::invalid_argument&) {
    return true;
  }
  return false;
}

template <typename Message>
ros_standin::Board<Message>& board() {
  return ros_standin::Board<Message>::get();
}

bool link_is(const DiagnosticArray& all, unsigned char level) {
  return all.status.size() == 2 && all.status[1].name == "robot_front: link" &&
         all.status[1].level == level;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    return 2;
  }
  expect(refused(rclcpp::NodeOptions()), "a node without a sensor is refused");
  expect(refused(rclcpp::NodeOptions()
                     .append_parameter_override("sensor", argv[1])
                     .append_parameter_override("cloud_step", 65)),
         "a cloud_step of 65 is refused");
  rclcpp::NodeOptions options;
  options.name_space = "/robot/front";
  options.append_parameter_override("sensor", argv[1])
      .append_parameter_override("cloud_step", 8)
      .append_parameter_override("keys", "");
  const stof_driver::SensorNode node(options);

  const auto placed = board<geometry_msgs::msg::TransformStamped>().newest("/tf_static");
  expect(placed.header.frame_id == "robot_front_link" &&
             placed.child_frame_id == "robot_front_left_optical_frame",
         "frames have the namespace's name");
  expect(board<Image>().await("/robot/front/depth/image_raw", kSeconds,
                              [](const Image& image) {
                                bool known = false;
                                for (const std::uint8_t byte : image.data) {
                                  known = known || byte != 0;
                                }
                                return known && image.width == 64 && image.height == 48 &&
                                       image.data.size() == 64U * 48 * 2 &&
                                       image.header.frame_id == "robot_front_left_optical_frame" &&
                                       image.header.stamp.sec > 1'500'000'000;
                              }),
         "an image with depth comes");
  expect(board<CameraInfo>().await("/robot/front/depth/camera_info", kSeconds,
                                   [](const CameraInfo& info) {
                                     return info.width == 64 && info.height == 48 && info.k[0] > 1;
                                   }),
         "a CameraInfo comes");
  expect(board<PointCloud2>().await("/robot/front/depth/points", kSeconds,
                                    [](const PointCloud2& cloud) {
                                      return cloud.width > 0 && cloud.width <= 8U * 6 &&
                                             cloud.data.size() ==
                                                 std::size_t{cloud.width} * cloud.point_step;
                                    }),
         "a cloud of at most a point a block comes");
  expect(board<DiagnosticArray>().await("/diagnostics", kSeconds,
                                        [](const DiagnosticArray& all) {
                                          return link_is(all, DiagnosticStatus::OK) &&
                                                 all.status[0].level != DiagnosticStatus::STALE;
                                        }),
         "diagnostics say that frames come");

  std::puts("ready");
  std::fflush(stdout);
  std::string line;
  std::getline(std::cin, line);
  expect(board<DiagnosticArray>().await(
             "/diagnostics", kSeconds,
             [](const DiagnosticArray& all) { return link_is(all, DiagnosticStatus::STALE); }),
         "diagnostics say that the sensor is silent");
  const int before = board<Image>().count("/robot/front/depth/image_raw");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  expect(board<Image>().count("/robot/front/depth/image_raw") == before,
         "a silent sensor brings no image");
  return wrong == 0 ? 0 : 1;
}

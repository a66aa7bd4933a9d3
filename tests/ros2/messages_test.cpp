// Frames of libstof as messages of ROS 2: the component's own source, on the stand-in.
#include "ros2/stof_driver/src/messages.h"

#include <array>
#include <cstring>

#include <gtest/gtest.h>

namespace {

// 4x2 pixels, with a lens unless told; what it points to is its own.
struct Made {
  std::array<std::uint16_t, 8> depth{0, 1, 2, 3, 4000, 4001, 4002, 65535};
  std::array<std::uint16_t, 8> width{0, 0, 0, 0, 40, 4000, 0, 0};
  stof_frame c = STOF_INIT(stof_frame);

  Made() {
    c.depth = plane(depth);
    c.interval_width = plane(width);
    c.has_calibration = 1;
    c.calibration.width = 4;
    c.calibration.height = 2;
    c.calibration.fx = 2;
    c.calibration.fy = 4;
    c.calibration.cx = 1.5;
    c.calibration.cy = 0.5;
    const std::array<double, 9> k{2, 0, 1.5, 0, 4, 0.5, 0, 0, 1};
    std::copy(k.begin(), k.end(), std::begin(c.calibration.k));
    c.calibration.depth_unit_m = 0.00025;
  }
  stof_plane plane(const std::array<std::uint16_t, 8>& pixels) const {
    stof_plane plane{};
    plane.data = pixels.data();
    plane.width = 4;
    plane.height = 2;
    plane.stride = 8;
    plane.bytes = sizeof pixels;
    plane.pixel_bytes = 2;
    return plane;
  }
  stof::Frame frame() const { return stof::Frame(c); }
};

TEST(Ros2Messages, ImageIsMillimetresRoundedHalfUpAndZeroIsUnknownAlone) {
  sensor_msgs::msg::Image image;
  ASSERT_TRUE(stof_driver::fill_image(Made().frame(), image));
  EXPECT_EQ(image.encoding, "16UC1");
  EXPECT_EQ(image.width, 4U);
  EXPECT_EQ(image.height, 2U);
  EXPECT_EQ(image.step, 8U);
  const std::vector<std::uint8_t> expected{0,    0,    1,    0,    1,    0,    1,    0,
                                           0xE8, 0x03, 0xE8, 0x03, 0xE9, 0x03, 0x00, 0x40};
  EXPECT_EQ(image.data, expected);
  Made none;
  none.c.depth.data = nullptr;
  EXPECT_FALSE(stof_driver::fill_image(none.frame(), image));
}

TEST(Ros2Messages, CameraInfoIsTheRectifiedLeftCamera) {
  sensor_msgs::msg::CameraInfo info;
  ASSERT_TRUE(stof_driver::fill_camera_info(Made().frame(), info));
  EXPECT_EQ(info.width, 4U);
  EXPECT_EQ(info.height, 2U);
  EXPECT_EQ(info.distortion_model, "plumb_bob");
  EXPECT_EQ(info.d, std::vector<double>(5, 0.0));
  EXPECT_EQ(info.k, (std::array<double, 9>{2, 0, 1.5, 0, 4, 0.5, 0, 0, 1}));
  EXPECT_EQ(info.p, (std::array<double, 12>{2, 0, 1.5, 0, 0, 4, 0.5, 0, 0, 0, 1, 0}));
  Made none;
  none.c.has_calibration = 0;
  EXPECT_FALSE(stof_driver::fill_camera_info(none.frame(), info));
}

TEST(Ros2Messages, CloudHasThePointOfEachBlockWhoseNearBoundIsNearest) {
  Made made;
  made.depth = {4000, 0, 0, 0, 0, 5000, 0, 0};
  made.width = {400, 0, 0, 0, 0, 4000, 0, 0};  // near bounds 3800 and 3000
  sensor_msgs::msg::PointCloud2 cloud;
  ASSERT_TRUE(stof_driver::fill_cloud(made.frame(), 2, cloud));
  ASSERT_EQ(cloud.width, 1U);  // the other block is unknown: no point
  EXPECT_EQ(cloud.height, 1U);
  EXPECT_EQ(cloud.point_step, 16U);
  ASSERT_EQ(cloud.data.size(), 16U);
  ASSERT_EQ(cloud.fields.size(), 4U);
  EXPECT_EQ(cloud.fields[3].name, "z_width");
  EXPECT_EQ(cloud.fields[3].offset, 12U);
  std::array<float, 4> point{};
  std::memcpy(point.data(), cloud.data.data(), sizeof point);
  EXPECT_EQ(point, (std::array<float, 4>{-0.3125F, 0.15625F, 1.25F, 1.0F}));
  EXPECT_FALSE(stof_driver::fill_cloud(made.frame(), 0, cloud));
  made.c.calibration.width = 8;
  EXPECT_FALSE(stof_driver::fill_cloud(made.frame(), 2, cloud));
}

TEST(Ros2Messages, StampIsTheMiddleOfTheExposureHere) {
  Made made;
  made.c.first_packet_ns = 5'000;
  EXPECT_EQ(stof_driver::exposure_here_ns(made.frame()), 5'000);
  made.c.has_info = 1;
  made.c.info.latency_ns = 2'000;
  EXPECT_EQ(stof_driver::exposure_here_ns(made.frame()), 3'000);
  made.c.exposure_here_ns = 2'500;
  EXPECT_EQ(stof_driver::exposure_here_ns(made.frame()), 2'500);
  EXPECT_EQ(stof_driver::time_of(3'000'000'001).sec, 3);
  EXPECT_EQ(stof_driver::time_of(3'000'000'001).nanosec, 1U);
  EXPECT_EQ(stof_driver::time_of(-1).sec, -1);
  EXPECT_EQ(stof_driver::time_of(-1).nanosec, 999'999'999U);
}

TEST(Ros2Messages, HealthIsStaleWhenTheSensorSaysNothing) {
  using Status = diagnostic_msgs::msg::DiagnosticStatus;
  EXPECT_EQ(stof_driver::health_status("front: health", "1", std::nullopt).level, Status::STALE);
  stof::Health health = STOF_INIT(stof_health);
  health.age_ns = 2'000'000'000;
  EXPECT_EQ(stof_driver::health_status("front: health", "1", health).level, Status::OK);
  health.severity = 1;
  EXPECT_EQ(stof_driver::health_status("front: health", "1", health).level, Status::WARN);
  health.severity = 3;
  health.active = 1;
  const Status critical = stof_driver::health_status("front: health", "1", health);
  EXPECT_EQ(critical.level, Status::ERROR);
  EXPECT_EQ(critical.name, "front: health");
  ASSERT_FALSE(critical.values.empty());
  EXPECT_EQ(critical.values.front().key, stof_condition_name(0));
  health.age_ns = 3'000'000'000;
  EXPECT_EQ(stof_driver::health_status("front: health", "1", health).level, Status::STALE);
}

}  // namespace

#include "host/bridge/type_hash.h"

#include <array>
#include <bit>

#include <gtest/gtest.h>

#include "host/bridge/topics.h"

namespace stof::bridge {
namespace {

// As `ros2 topic info -v` of ROS 2 Jazzy prints them; of DiagnosticArray no published value was
// found, the one here is that of the rule computed in Python.
TEST(TypeHashTest, IsTheOneOfRos2Jazzy) {
  EXPECT_EQ(type_hash(recording::image_schema()),
            "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47");
  EXPECT_EQ(type_hash(recording::camera_info_schema()),
            "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275");
  EXPECT_EQ(type_hash(recording::point_cloud_schema()),
            "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5");
  EXPECT_EQ(type_hash(recording::transforms_schema()),
            "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087");
  EXPECT_EQ(type_hash(recording::string_schema()),
            "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18");
  EXPECT_EQ(type_hash(recording::diagnostics_schema()),
            "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e");
}

TEST(TypeHashTest, SchemaThatIsNotCompleteHasNone) {
  mcap::Schema schema = recording::image_schema();
  schema.data.resize(schema.data.find("MSG: "));
  EXPECT_EQ(type_hash(schema), "");
  schema.data = "strange thing\n";
  EXPECT_EQ(type_hash(schema), "");
  schema.data = "string<=10 bounded\n";
  EXPECT_EQ(type_hash(schema), "");
}

TEST(TopicsTest, NamesAreThoseOfRos2) {
  EXPECT_EQ(dds_type_name("sensor_msgs/msg/Image"), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(dds_topic_name(Topic::kDepth, "robot/front"), "rt/robot/front/depth/image_raw");
  EXPECT_EQ(dds_topic_name(Topic::kTransforms, "robot/front"), "rt/tf_static");
  EXPECT_EQ(frame_ids("robot/front").optical, "robot_front_left_optical_frame");
  EXPECT_EQ(frame_ids("stof").optical, recording::kOpticalFrame) << "as in recordings";
}

TEST(TopicsTest, NamespacesAreWordsWithSlashes) {
  for (const char* const good : {"stof", "a", "_x9", "robot/front", "a/b/c"}) {
    EXPECT_TRUE(good_namespace(good)) << good;
  }
  for (const char* const bad : {"", "/", "/a", "a/", "a//b", "9a", "a/9", "a b", "a-b", "a\n"}) {
    EXPECT_FALSE(good_namespace(bad)) << bad;
  }
}

using Vector = std::array<double, 3>;

// v turned by the quaternion q: v + 2 w (u x v) + 2 u x (u x v), u the vector part.
Vector turned(const std::array<double, 4>& q, const Vector& v) {
  const auto cross = [](const Vector& a, const Vector& b) {
    return Vector{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Vector u{q[0], q[1], q[2]};
  const Vector once = cross(u, v);
  const Vector twice = cross(u, once);
  return {v[0] + 2 * q[3] * once[0] + 2 * twice[0], v[1] + 2 * q[3] * once[1] + 2 * twice[1],
          v[2] + 2 * q[3] * once[2] + 2 * twice[2]};
}

// x right, y down, z ahead of the camera, in x ahead, y left, z up of its body.
TEST(TopicsTest, OpticalFrameIsThatOfRep103) {
  const recording::Buffer bytes = static_transforms(frame_ids("s"), {}, 0);
  recording::CdrReader from(bytes);
  ASSERT_EQ(from.number<std::uint32_t>(), 1U);
  from.number<std::uint32_t>();
  from.number<std::uint32_t>();
  EXPECT_EQ(from.text(), "s_link");
  EXPECT_EQ(from.text(), "s_left_optical_frame");
  const auto number = [&] { return std::bit_cast<double>(from.number<std::uint64_t>()); };
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(number(), 0);
  }
  std::array<double, 4> rotation{};
  for (double& value : rotation) {
    value = number();
  }
  EXPECT_EQ(turned(rotation, {0, 0, 1}), (Vector{1, 0, 0}));
  EXPECT_EQ(turned(rotation, {1, 0, 0}), (Vector{0, -1, 0}));
  EXPECT_EQ(turned(rotation, {0, 1, 0}), (Vector{0, 0, -1}));
  EXPECT_TRUE(from.ok());
}

}  // namespace
}  // namespace stof::bridge

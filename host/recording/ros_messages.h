#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/health.h"
#include "firmware/wire/packet.h"
#include "host/client/frame/point_cloud.h"
#include "host/recording/cdr.h"
#include "host/recording/mcap/records.h"

// The types of the messages of a recording, and their bytes. docs/RECORDING.md.
namespace stof::recording {

// A ROS 2 schema: name and text of the definition, those of what it is made of behind it.
mcap::Schema image_schema();
mcap::Schema camera_info_schema();
mcap::Schema diagnostics_schema();
mcap::Schema point_cloud_schema();
mcap::Schema transforms_schema();  // tf2_msgs/msg/TFMessage
mcap::Schema packet_schema();      // stof_msgs/msg/Packet
mcap::Schema string_schema();      // std_msgs/msg/String

inline constexpr std::string_view kOpticalFrame = "stof_left_optical_frame";

// std_msgs/msg/Header: `stamp_ns` of the sensor's clock, clamped to what a ROS time holds.
struct MessageHeader {
  std::int64_t stamp_ns = 0;
  std::string frame_id{kOpticalFrame};
};

// sensor_msgs/msg/Image, rows without gaps.
struct Image {
  MessageHeader header{};
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string encoding{};  // "16UC1", "8UC1" or "mono8"
  Bytes data{};            // borrowed; little-endian
};
Buffer encode(const Image& image);
// Empty: no such message, or of another size than it says; its data are borrowed.
std::optional<Image> decode_image(Bytes message);

// sensor_msgs/msg/CameraInfo of the rectified left camera: no distortion.
Buffer encode_camera_info(const MessageHeader& header, const wire::CalibrationPacket& calibration);

// diagnostic_msgs/msg/DiagnosticStatus.
enum class DiagnosticLevel : std::uint8_t { kOk = 0, kWarn = 1, kError = 2, kStale = 3 };
struct DiagnosticStatus {
  DiagnosticLevel level = DiagnosticLevel::kOk;
  std::string name{};
  std::string message{};
  std::string hardware_id{};
  std::vector<std::pair<std::string, std::string>> values{};
};
// The health of a sensor: each active condition and each figure by its name.
DiagnosticStatus health_status(std::string name, std::uint32_t device_id,
                               const wire::HealthReport& health);
// diagnostic_msgs/msg/DiagnosticArray.
Buffer encode_diagnostics(const MessageHeader& header, std::span<const DiagnosticStatus> statuses);

// sensor_msgs/msg/PointCloud2, unordered: float32 x, y, z and z_width, metres, of
// client::point_cloud().
Buffer encode_point_cloud(const MessageHeader& header, std::span<const client::Point> points);

// geometry_msgs/msg/TransformStamped: where `child` is in `parent`.
struct Transform {
  std::string parent{};
  std::string child{};
  std::array<double, 3> translation_m{};
  std::array<double, 4> rotation{0, 0, 0, 1};  // unit quaternion x, y, z, w
};
// tf2_msgs/msg/TFMessage.
Buffer encode_transforms(std::int64_t stamp_ns, std::span<const Transform> transforms);

// What docs/WIRE.md calls a packet: its payload with what is known from its header. For what no
// type of ROS holds whole.
struct Packet {
  MessageHeader header{};
  wire::Origin origin{};
  wire::FrameStamp stamp{};
  wire::PacketType type = wire::PacketType::kFrameInfo;
  std::uint32_t packets = 0;  // that the frame was sent in; these three: 0 where it is of no frame
  std::uint32_t missing_packets = 0;
  std::uint32_t recovered_packets = 0;
  Bytes payload{};  // borrowed; empty: did not arrive
};
// std_msgs/msg/String.
Buffer encode_string(std::string_view text);
std::optional<std::string> decode_string(Bytes message);

Buffer encode(const Packet& packet);
std::optional<Packet> decode_packet(Bytes message);

}  // namespace stof::recording

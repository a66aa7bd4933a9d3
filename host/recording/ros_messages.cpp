#include "host/recording/ros_messages.h"

#include <algorithm>
#include <limits>

#include "firmware/wire/messages/conditions.h"

namespace stof::recording {
namespace {

constexpr const char* kImageText = R"(std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
)";

constexpr const char* kCameraInfoText = R"(std_msgs/Header header
uint32 height
uint32 width
string distortion_model
float64[] d
float64[9] k
float64[9] r
float64[12] p
uint32 binning_x
uint32 binning_y
sensor_msgs/RegionOfInterest roi
)";

constexpr const char* kRegionText = R"(uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
)";

constexpr const char* kDiagnosticsText = R"(std_msgs/Header header
diagnostic_msgs/DiagnosticStatus[] status
)";

constexpr const char* kStatusText = R"(byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
)";

constexpr const char* kKeyValueText = "string key\nstring value\n";

constexpr const char* kPointCloudText = R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
)";

constexpr const char* kPointFieldText = R"(uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
)";

constexpr const char* kTransformsText = "geometry_msgs/TransformStamped[] transforms\n";
constexpr const char* kTransformStampedText = R"(std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
)";
constexpr const char* kTransformText = R"(geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
)";
constexpr const char* kVectorText = "float64 x\nfloat64 y\nfloat64 z\n";
constexpr const char* kQuaternionText = "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n";

constexpr const char* kPacketText = R"(std_msgs/Header header
uint32 device_id
uint32 session_id
uint32 frame_number
uint32 freshness
int64 exposure_middle_ns
uint8 health
uint8 clock
uint8 type
uint32 packets
uint32 missing_packets
uint32 recovered_packets
uint8[] payload
)";

constexpr const char* kHeaderText = "builtin_interfaces/Time stamp\nstring frame_id\n";
constexpr const char* kTimeText = "int32 sec\nuint32 nanosec\n";

struct Part {
  const char* name;
  const char* text;
};

mcap::Schema schema_of(const char* name, const char* text, std::initializer_list<Part> parts) {
  mcap::Schema schema{.name = name, .encoding = "ros2msg", .data = text};
  for (const Part& part : parts) {
    schema.data += std::string(80, '=') + "\nMSG: " + part.name + "\n" + part.text;
  }
  return schema;
}

constexpr Part kHeaderPart{"std_msgs/Header", kHeaderText};
constexpr Part kTimePart{"builtin_interfaces/Time", kTimeText};

void put_header(CdrWriter& to, const MessageHeader& header) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  std::int64_t seconds = header.stamp_ns / kSecond;
  std::int64_t nanoseconds = header.stamp_ns % kSecond;
  if (nanoseconds < 0) {
    nanoseconds += kSecond;
    --seconds;
  }
  using Limit = std::numeric_limits<std::int32_t>;
  to.number(
      static_cast<std::int32_t>(std::clamp<std::int64_t>(seconds, Limit::min(), Limit::max())));
  to.number(static_cast<std::uint32_t>(nanoseconds));
  to.text(header.frame_id);
}

MessageHeader get_header(CdrReader& from) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  MessageHeader header;
  header.stamp_ns = from.number<std::int32_t>() * kSecond;
  header.stamp_ns += from.number<std::uint32_t>();
  header.frame_id = from.text();
  return header;
}

std::uint32_t pixel_bytes(std::string_view encoding) {
  if (encoding == "16UC1") {
    return 2;
  }
  return encoding == "8UC1" || encoding == "mono8" ? 1 : 0;
}

}  // namespace

mcap::Schema image_schema() {
  return schema_of("sensor_msgs/msg/Image", kImageText, {kHeaderPart, kTimePart});
}
mcap::Schema camera_info_schema() {
  return schema_of("sensor_msgs/msg/CameraInfo", kCameraInfoText,
                   {kHeaderPart, kTimePart, {"sensor_msgs/RegionOfInterest", kRegionText}});
}
mcap::Schema diagnostics_schema() {
  return schema_of("diagnostic_msgs/msg/DiagnosticArray", kDiagnosticsText,
                   {kHeaderPart,
                    kTimePart,
                    {"diagnostic_msgs/DiagnosticStatus", kStatusText},
                    {"diagnostic_msgs/KeyValue", kKeyValueText}});
}
mcap::Schema point_cloud_schema() {
  return schema_of("sensor_msgs/msg/PointCloud2", kPointCloudText,
                   {kHeaderPart, kTimePart, {"sensor_msgs/PointField", kPointFieldText}});
}
mcap::Schema transforms_schema() {
  return schema_of("tf2_msgs/msg/TFMessage", kTransformsText,
                   {{"geometry_msgs/TransformStamped", kTransformStampedText},
                    kHeaderPart,
                    kTimePart,
                    {"geometry_msgs/Transform", kTransformText},
                    {"geometry_msgs/Vector3", kVectorText},
                    {"geometry_msgs/Quaternion", kQuaternionText}});
}
mcap::Schema packet_schema() {
  return schema_of("stof_msgs/msg/Packet", kPacketText, {kHeaderPart, kTimePart});
}

Buffer encode(const Image& image) {
  CdrWriter to;
  constexpr std::size_t kHead = 128;
  to.reserve(image.data.size() + kHead);
  put_header(to, image.header);
  to.number(image.height);
  to.number(image.width);
  to.text(image.encoding);
  to.number(std::uint8_t{0});  // little-endian
  to.number(image.width * pixel_bytes(image.encoding));
  to.octets(image.data);
  return std::move(to).take();
}

std::optional<Image> decode_image(Bytes message) {
  CdrReader from(message);
  Image image;
  image.header = get_header(from);
  image.height = from.number<std::uint32_t>();
  image.width = from.number<std::uint32_t>();
  image.encoding = from.text();
  const auto big_endian = from.number<std::uint8_t>();
  const auto step = from.number<std::uint32_t>();
  image.data = from.octets();
  const std::uint64_t row = std::uint64_t{image.width} * pixel_bytes(image.encoding);
  // A side fits 16 bits, as on the wire.
  constexpr std::uint32_t kMostSide = 65535;
  const bool good = from.ok() && big_endian == 0 && row != 0 && image.width <= kMostSide &&
                    image.height <= 4 * kMostSide && step == row &&
                    image.data.size() == row * image.height;
  return good ? std::optional(std::move(image)) : std::nullopt;
}

Buffer encode_camera_info(const MessageHeader& header, const wire::CalibrationPacket& calibration) {
  constexpr double kPixelScale = 65536;
  const double fx = calibration.fx / kPixelScale;
  const double fy = calibration.fy / kPixelScale;
  const double cx = calibration.cx / kPixelScale;
  const double cy = calibration.cy / kPixelScale;
  CdrWriter to;
  put_header(to, header);
  to.number(std::uint32_t{calibration.image_height});
  to.number(std::uint32_t{calibration.image_width});
  to.text("plumb_bob");
  constexpr std::uint32_t kDistortions = 5;
  to.number(kDistortions);
  const auto all = [&to](std::initializer_list<double> values) {
    for (const double value : values) {
      to.number(value);
    }
  };
  all({0, 0, 0, 0, 0});
  all({fx, 0, cx, 0, fy, cy, 0, 0, 1});
  all({1, 0, 0, 0, 1, 0, 0, 0, 1});
  all({fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0});
  for (int zero = 0; zero < 6; ++zero) {  // binning, region of interest: all of it
    to.number(std::uint32_t{0});
  }
  to.number(std::uint8_t{0});
  return std::move(to).take();
}

DiagnosticStatus health_status(std::string name, std::uint32_t device_id,
                               const wire::HealthReport& health) {
  DiagnosticStatus status{.name = std::move(name), .hardware_id = std::to_string(device_id)};
  status.values = {{"uptime_ms", std::to_string(health.uptime_ms)},
                   {"severity", std::to_string(static_cast<int>(health.severity))},
                   {"reaction", std::to_string(static_cast<int>(health.reaction))},
                   {"subscribers", std::to_string(health.subscribers)},
                   {"rate_millihertz", std::to_string(health.rate_millihertz)},
                   {"latency_us", std::to_string(health.latency_us)},
                   {"longest_latency_us", std::to_string(health.longest_latency_us)},
                   {"settings_revision", std::to_string(health.settings_revision)},
                   {"edges", std::to_string(health.counters.edges)},
                   {"frames_published", std::to_string(health.counters.frames_published)},
                   {"mispaired", std::to_string(health.counters.mispaired)},
                   {"timeouts", std::to_string(health.counters.timeouts)},
                   {"deadline_misses", std::to_string(health.counters.deadline_misses)},
                   {"link_drops", std::to_string(health.counters.link_drops)},
                   {"packets_sent", std::to_string(health.packets_sent)}};
  for (std::uint8_t k = 0; k < 32; ++k) {
    if (((health.active >> k) & 1U) == 0) {
      continue;
    }
    const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(k));
    const std::string condition = info != nullptr ? info->name : "condition_" + std::to_string(k);
    status.values.emplace_back(condition, info != nullptr ? info->text : "of a newer sensor");
    status.message += (status.message.empty() ? "" : ", ") + condition;
  }
  if (status.message.empty()) {
    status.message = "good";
  }
  using Level = DiagnosticLevel;
  // Of info, minor, major and critical.
  constexpr std::array<Level, 4> kLevels{Level::kOk, Level::kWarn, Level::kWarn, Level::kError};
  const auto severity = static_cast<std::size_t>(health.severity);
  status.level = kLevels[std::min(severity, kLevels.size() - 1)];
  return status;
}

Buffer encode_diagnostics(const MessageHeader& header, std::span<const DiagnosticStatus> statuses) {
  CdrWriter to;
  put_header(to, header);
  to.number(static_cast<std::uint32_t>(statuses.size()));
  for (const DiagnosticStatus& status : statuses) {
    to.number(static_cast<std::uint8_t>(status.level));
    to.text(status.name);
    to.text(status.message);
    to.text(status.hardware_id);
    to.number(static_cast<std::uint32_t>(status.values.size()));
    for (const auto& [key, value] : status.values) {
      to.text(key);
      to.text(value);
    }
  }
  return std::move(to).take();
}

Buffer encode_point_cloud(const MessageHeader& header, std::span<const client::Point> points) {
  constexpr std::array<const char*, 4> kFields{"x", "y", "z", "z_width"};
  constexpr std::uint32_t kPointStep = kFields.size() * sizeof(float);
  constexpr std::uint8_t kFloat32 = 7;
  constexpr std::size_t kHead = 256;
  const auto count = static_cast<std::uint32_t>(points.size());
  CdrWriter to;
  to.reserve(points.size() * kPointStep + kHead);
  put_header(to, header);
  to.number(std::uint32_t{1});  // height
  to.number(count);
  to.number(static_cast<std::uint32_t>(kFields.size()));
  for (std::uint32_t k = 0; k < kFields.size(); ++k) {
    to.text(kFields[k]);
    to.number(static_cast<std::uint32_t>(k * sizeof(float)));
    to.number(kFloat32);
    to.number(std::uint32_t{1});
  }
  to.number(std::uint8_t{0});  // little-endian
  to.number(kPointStep);
  to.number(count * kPointStep);
  to.number(count * kPointStep);  // bytes
  for (const client::Point& point : points) {
    const std::array<float, kFields.size()> values{point.x, point.y, point.z, point.z_width};
    to.raw(std::as_bytes(std::span(values)));
  }
  to.number(std::uint8_t{1});  // is_dense: every point has a place
  return std::move(to).take();
}

Buffer encode_transforms(std::int64_t stamp_ns, std::span<const Transform> transforms) {
  CdrWriter to;
  to.number(static_cast<std::uint32_t>(transforms.size()));
  for (const Transform& transform : transforms) {
    put_header(to, {.stamp_ns = stamp_ns, .frame_id = transform.parent});
    to.text(transform.child);
    for (const double value : transform.translation_m) {
      to.number(value);
    }
    for (const double value : transform.rotation) {
      to.number(value);
    }
  }
  return std::move(to).take();
}

mcap::Schema string_schema() { return schema_of("std_msgs/msg/String", "string data\n", {}); }

Buffer encode_string(std::string_view text) {
  CdrWriter to;
  to.text(text);
  return std::move(to).take();
}

std::optional<std::string> decode_string(Bytes message) {
  CdrReader from(message);
  std::string text = from.text();
  return from.ok() ? std::optional(std::move(text)) : std::nullopt;
}

Buffer encode(const Packet& packet) {
  CdrWriter to;
  put_header(to, packet.header);
  to.number(packet.origin.device_id);
  to.number(packet.origin.session_id);
  to.number(packet.stamp.number);
  to.number(packet.stamp.freshness);
  to.number(packet.stamp.exposure_middle_ns);
  to.number(static_cast<std::uint8_t>(packet.stamp.health));
  to.number(static_cast<std::uint8_t>(packet.stamp.clock));
  to.number(static_cast<std::uint8_t>(packet.type));
  to.number(packet.packets);
  to.number(packet.missing_packets);
  to.number(packet.recovered_packets);
  to.octets(packet.payload);
  return std::move(to).take();
}

std::optional<Packet> decode_packet(Bytes message) {
  CdrReader from(message);
  Packet packet;
  packet.header = get_header(from);
  packet.origin.device_id = from.number<std::uint32_t>();
  packet.origin.session_id = from.number<std::uint32_t>();
  packet.stamp.number = from.number<std::uint32_t>();
  packet.stamp.freshness = from.number<std::uint32_t>();
  packet.stamp.exposure_middle_ns = from.number<std::int64_t>();
  packet.stamp.health = static_cast<wire::Health>(from.number<std::uint8_t>());
  packet.stamp.clock = static_cast<wire::ClockState>(from.number<std::uint8_t>());
  packet.type = static_cast<wire::PacketType>(from.number<std::uint8_t>());
  packet.packets = from.number<std::uint32_t>();
  packet.missing_packets = from.number<std::uint32_t>();
  packet.recovered_packets = from.number<std::uint32_t>();
  packet.payload = from.octets();
  return from.ok() ? std::optional(std::move(packet)) : std::nullopt;
}

}  // namespace stof::recording

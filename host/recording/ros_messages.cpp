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

Buffer encode_diagnostics(const MessageHeader& header, std::uint32_t device_id,
                          const wire::HealthReport& health) {
  using Entry = std::pair<std::string, std::string>;
  std::vector<Entry> values{{"uptime_ms", std::to_string(health.uptime_ms)},
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
  std::string message;
  for (std::uint8_t k = 0; k < 32; ++k) {
    if (((health.active >> k) & 1U) == 0) {
      continue;
    }
    const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(k));
    const std::string name = info != nullptr ? info->name : "condition_" + std::to_string(k);
    values.emplace_back(name, info != nullptr ? info->text : "of a newer sensor");
    message += (message.empty() ? "" : ", ") + name;
  }
  constexpr std::array<std::uint8_t, 4> kLevels{0, 1, 1, 2};  // info, minor, major, critical
  const auto severity = static_cast<std::size_t>(health.severity);
  CdrWriter to;
  put_header(to, header);
  to.number(std::uint32_t{1});
  to.number(kLevels[std::min(severity, kLevels.size() - 1)]);
  to.text("stof: health");
  to.text(message.empty() ? "good" : message);
  to.text(std::to_string(device_id));
  to.number(static_cast<std::uint32_t>(values.size()));
  for (const auto& [key, value] : values) {
    to.text(key);
    to.text(value);
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

#include "messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include <diagnostic_msgs/msg/key_value.hpp>
#include <sensor_msgs/msg/point_field.hpp>

namespace stof_driver {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr double kUsualUnitM = 0.00025;  // of a frame that came before the first calibration

double depth_unit_m(const stof::Frame& frame) {
  const std::optional<stof::Calibration> lens = frame.calibration();
  return lens && lens->depth_unit_m > 0 ? lens->depth_unit_m : kUsualUnitM;
}

struct Nearest {
  int x = 0;
  int y = 0;
  int twice_near = 0;  // 2 * depth - width
};

std::optional<Nearest> nearest_of_block(const stof::Frame& frame, int left, int top, int step) {
  const stof::Image<std::uint16_t> depth = frame.depth();
  const stof::Image<std::uint16_t> width = frame.interval_width();
  std::optional<Nearest> nearest;
  for (int y = top; y < std::min(top + step, depth.height()); ++y) {
    for (int x = left; x < std::min(left + step, depth.width()); ++x) {
      if (depth.at(x, y) == 0) {
        continue;
      }
      const bool known = !width.empty() && width.arrived(x, y);
      const int near = 2 * depth.at(x, y) - (known ? width.at(x, y) : 0);
      if (!nearest || near < nearest->twice_near) {
        nearest = Nearest{x, y, near};
      }
    }
  }
  return nearest;
}

diagnostic_msgs::msg::KeyValue key_value(const std::string& key, const std::string& value) {
  diagnostic_msgs::msg::KeyValue pair;
  pair.key = key;
  pair.value = value;
  return pair;
}

// Major and critical: depth is not to be trusted as it was.
unsigned char level_of(std::uint32_t severity) {
  using Status = diagnostic_msgs::msg::DiagnosticStatus;
  if (severity >= 2) {
    return Status::ERROR;
  }
  return severity == 1 ? Status::WARN : Status::OK;
}

}  // namespace

builtin_interfaces::msg::Time time_of(std::int64_t ns) {
  const std::int64_t part = ((ns % kSecond) + kSecond) % kSecond;
  builtin_interfaces::msg::Time time;
  time.sec = static_cast<std::int32_t>((ns - part) / kSecond);
  time.nanosec = static_cast<std::uint32_t>(part);
  return time;
}

std::int64_t exposure_here_ns(const stof::Frame& frame) {
  if (frame.c().exposure_here_ns != 0) {
    return frame.c().exposure_here_ns;
  }
  const std::optional<stof::Info> info = frame.info();
  return frame.c().first_packet_ns - (info ? info->latency_ns : 0);
}

bool fill_image(const stof::Frame& frame, sensor_msgs::msg::Image& image) {
  const stof::Image<std::uint16_t> depth = frame.depth();
  if (depth.empty()) {
    return false;
  }
  constexpr long kMost = 65535;
  const double millimetres = depth_unit_m(frame) * 1000;
  image.width = static_cast<std::uint32_t>(depth.width());
  image.height = static_cast<std::uint32_t>(depth.height());
  image.encoding = "16UC1";
  image.is_bigendian = 0;
  image.step = image.width * 2;
  image.data.resize(std::size_t{image.step} * image.height);
  std::uint8_t* to = image.data.data();
  for (int y = 0; y < depth.height(); ++y) {
    const std::uint16_t* const row = depth.row(y);
    for (int x = 0; x < depth.width(); ++x) {
      // What is known never rounds to unknown.
      const long rounded =
          row[x] == 0 ? 0 : std::clamp(std::lround(row[x] * millimetres), 1L, kMost);
      *to++ = static_cast<std::uint8_t>(rounded & 0xFF);
      *to++ = static_cast<std::uint8_t>(rounded >> 8);
    }
  }
  return true;
}

bool fill_camera_info(const stof::Frame& frame, sensor_msgs::msg::CameraInfo& info) {
  const std::optional<stof::Calibration> lens = frame.calibration();
  if (!lens) {
    return false;
  }
  info.width = lens->width;
  info.height = lens->height;
  info.distortion_model = "plumb_bob";
  info.d.assign(5, 0.0);
  std::copy(std::begin(lens->k), std::end(lens->k), info.k.begin());
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {lens->fx, 0, lens->cx, 0, 0, lens->fy, lens->cy, 0, 0, 0, 1, 0};
  return true;
}

bool fill_cloud(const stof::Frame& frame, int step, sensor_msgs::msg::PointCloud2& cloud) {
  const stof::Image<std::uint16_t> depth = frame.depth();
  const std::optional<stof::Calibration> lens = frame.calibration();
  if (depth.empty() || !lens || step < 1 || step > kMostCloudStep ||
      static_cast<int>(lens->width) != depth.width() ||
      static_cast<int>(lens->height) != depth.height()) {
    return false;
  }
  constexpr std::array<const char*, 4> kNames{"x", "y", "z", "z_width"};
  cloud.fields.clear();
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    sensor_msgs::msg::PointField field;
    field.name = kNames[k];
    field.offset = static_cast<std::uint32_t>(k * sizeof(float));
    field.datatype = sensor_msgs::msg::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.is_bigendian = false;
  cloud.is_dense = true;
  cloud.point_step = static_cast<std::uint32_t>(kNames.size() * sizeof(float));
  cloud.data.clear();
  const stof::Image<std::uint16_t> width = frame.interval_width();
  for (int top = 0; top < depth.height(); top += step) {
    for (int left = 0; left < depth.width(); left += step) {
      const std::optional<Nearest> at = nearest_of_block(frame, left, top, step);
      if (!at) {
        continue;
      }
      const double z = depth.at(at->x, at->y) * lens->depth_unit_m;
      const bool known = !width.empty() && width.arrived(at->x, at->y);
      const std::array<float, 4> point{
          static_cast<float>((at->x - lens->cx) / lens->fx * z),
          static_cast<float>((at->y - lens->cy) / lens->fy * z), static_cast<float>(z),
          known ? static_cast<float>(width.at(at->x, at->y) * lens->depth_unit_m) : -1.0F};
      const std::size_t before = cloud.data.size();
      cloud.data.resize(before + sizeof point);
      std::memcpy(&cloud.data[before], point.data(), sizeof point);
    }
  }
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(cloud.data.size() / cloud.point_step);
  cloud.row_step = static_cast<std::uint32_t>(cloud.data.size());
  return true;
}

diagnostic_msgs::msg::DiagnosticStatus health_status(const std::string& name,
                                                     const std::string& hardware_id,
                                                     const std::optional<stof::Health>& health) {
  using Status = diagnostic_msgs::msg::DiagnosticStatus;
  constexpr std::int64_t kTold = 5 * kSecond / 2;
  Status status;
  status.name = name;
  status.hardware_id = hardware_id;
  if (!health || health->age_ns > kTold) {
    status.level = Status::STALE;
    status.message = "the sensor says nothing";
    return status;
  }
  status.level = level_of(health->severity);
  status.message = std::string("robot: ") + stof_reaction_name(health->reaction);
  for (unsigned condition = 0; condition < 32; ++condition) {
    if (((health->active >> condition) & 1U) != 0) {
      status.values.push_back(
          key_value(stof_condition_name(condition), stof_condition_text(condition)));
    }
  }
  status.values.push_back(key_value("rate_hz", std::to_string(health->rate_hz)));
  status.values.push_back(key_value("latency_s", std::to_string(health->latency_s)));
  status.values.push_back(key_value("frames_published", std::to_string(health->frames_published)));
  return status;
}

}  // namespace stof_driver

#include "host/bridge/topics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stof::bridge {
namespace {

constexpr bool is_letter(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

std::array<double, 4> quaternion_of(const std::array<double, 3>& roll_pitch_yaw) {
  const auto [roll, pitch, yaw] = roll_pitch_yaw;
  const double cr = std::cos(roll / 2);
  const double sr = std::sin(roll / 2);
  const double cp = std::cos(pitch / 2);
  const double sp = std::sin(pitch / 2);
  const double cy = std::cos(yaw / 2);
  const double sy = std::sin(yaw / 2);
  return {sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy,
          cr * cp * cy + sr * sp * sy};
}

}  // namespace

bool good_namespace(std::string_view name) noexcept {
  bool begins = true;
  for (const char c : name) {
    if (c == '/' ? begins : !is_letter(c) && (begins || c < '0' || c > '9')) {
      return false;
    }
    begins = c == '/';
  }
  return !begins;
}

FrameIds frame_ids(std::string_view name_space) {
  std::string prefix(name_space);
  std::ranges::replace(prefix, '/', '_');
  return {.link = prefix + "_link", .optical = prefix + "_left_optical_frame"};
}

recording::Buffer static_transforms(const FrameIds& frames, const Mount& mount,
                                    std::int64_t stamp_ns) {
  std::vector<recording::Transform> transforms;
  if (!mount.parent.empty()) {
    transforms.push_back({.parent = mount.parent,
                          .child = frames.link,
                          .translation_m = mount.translation_m,
                          .rotation = quaternion_of(mount.roll_pitch_yaw)});
  }
  // Roll and yaw of minus a quarter turn.
  transforms.push_back(
      {.parent = frames.link, .child = frames.optical, .rotation = {-0.5, 0.5, -0.5, 0.5}});
  return recording::encode_transforms(stamp_ns, transforms);
}

}  // namespace stof::bridge

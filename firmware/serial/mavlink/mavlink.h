#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

// MAVLink version 2, as much of it as an obstacle sensor says. Numbers are those of common.xml.
namespace stof::firmware::mavlink {

inline constexpr std::size_t kMaxFrame = 280;  // with 255 bytes of payload and a signature
inline constexpr std::size_t kDirections = 72;
inline constexpr std::uint16_t kUnknownDistance = 65'535;
inline constexpr std::uint8_t kUnknownVariance = 255;

// CRC-16/MCRF4XX of `bytes`, going on from `crc`.
std::uint16_t crc16(std::span<const std::byte> bytes, std::uint16_t crc = 0xFFFF) noexcept;

// A message's number, the length of its payload with all extensions, and the byte that ties its CRC
// to its layout.
struct MessageKind {
  std::uint32_t id = 0;
  std::uint8_t length_v1 = 0;  // without extensions
  std::uint8_t length = 0;
  std::uint8_t crc_extra = 0;
};
inline constexpr MessageKind kHeartbeatKind{.id = 0, .length_v1 = 9, .length = 9, .crc_extra = 50};
inline constexpr MessageKind kPingKind{.id = 4, .length_v1 = 14, .length = 14, .crc_extra = 237};
inline constexpr MessageKind kDistanceSensorKind{
    .id = 132, .length_v1 = 14, .length = 39, .crc_extra = 85};
inline constexpr MessageKind kObstacleDistanceKind{
    .id = 330, .length_v1 = 158, .length = 167, .crc_extra = 23};

enum class State : std::uint8_t { kActive = 4, kCritical = 5, kEmergency = 6 };  // MAV_STATE

// HEARTBEAT of an onboard controller (MAV_TYPE 18) that is no autopilot (MAV_AUTOPILOT 8).
struct Heartbeat {
  State state = State::kActive;
};

// OBSTACLE_DISTANCE in MAV_FRAME_BODY_FRD, of a sensor of MAV_DISTANCE_SENSOR_UNKNOWN.
struct ObstacleDistance {
  std::uint64_t time_us = 0;
  std::array<std::uint16_t, kDirections> distances_cm{};  // kUnknownDistance: unknown
  std::uint16_t least_cm = 0;
  std::uint16_t most_cm = 0;
  float increment_deg = 0;     // from the middle of one direction to the next, clockwise
  float angle_offset_deg = 0;  // of the first from straight ahead
};

// DISTANCE_SENSOR that looks ahead (MAV_SENSOR_ROTATION_NONE), id 0.
struct DistanceSensor {
  std::uint32_t time_boot_ms = 0;
  std::uint16_t least_cm = 0;
  std::uint16_t most_cm = 0;
  std::uint16_t distance_cm = 0;
  std::uint8_t variance_cm2 = kUnknownVariance;
  float horizontal_fov_rad = 0;
  float vertical_fov_rad = 0;
  std::uint8_t quality = 0;  // percent; 0: not said, 1: invalid
};

using Buffer = std::array<std::byte, kMaxFrame>;

// Messages of one component, in sequence. The returned frame is a part of `buffer`.
class Writer {
 public:
  Writer(std::uint8_t system, std::uint8_t component) noexcept
      : system_(system), component_(component) {}

  void name(std::uint8_t system, std::uint8_t component) noexcept {
    system_ = system;
    component_ = component;
  }
  std::span<const std::byte> write(const Heartbeat& message, Buffer& buffer) noexcept;
  std::span<const std::byte> write(const ObstacleDistance& message, Buffer& buffer) noexcept;
  std::span<const std::byte> write(const DistanceSensor& message, Buffer& buffer) noexcept;

 private:
  // The payload lies in `buffer` already, kind.length bytes of it.
  std::span<const std::byte> seal(const MessageKind& kind, Buffer& buffer) noexcept;

  std::uint8_t system_;
  std::uint8_t component_;
  std::uint8_t sequence_ = 0;
};

}  // namespace stof::firmware::mavlink

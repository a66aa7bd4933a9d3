#include "firmware/serial/mavlink/mavlink.h"

#include <algorithm>
#include <bit>

#include "firmware/wire/bytes.h"

namespace stof::firmware::mavlink {
namespace {

using wire::put_u16;
using wire::put_u32;
using wire::put_u64;
using wire::put_u8;

constexpr std::size_t kHeaderBytes = 10;
constexpr std::size_t kCrcBytes = 2;
constexpr std::uint8_t kMagic = 0xFD;

constexpr std::uint8_t kOnboardController = 18;  // MAV_TYPE
constexpr std::uint8_t kNoAutopilot = 8;         // MAV_AUTOPILOT_INVALID
constexpr std::uint8_t kProtocolVersion = 3;     // what HEARTBEAT says of version 2 as well
constexpr std::uint8_t kUnknownSensor = 4;       // MAV_DISTANCE_SENSOR
constexpr std::uint8_t kBodyFrd = 12;            // MAV_FRAME

void put_float(std::span<std::byte, 4> to, float value) noexcept {
  static_assert(sizeof(float) == 4);
  put_u32(to, std::bit_cast<std::uint32_t>(value));
}

std::span<std::byte> payload_of(const MessageKind& kind, Buffer& buffer) noexcept {
  const std::span<std::byte> payload = std::span(buffer).subspan(kHeaderBytes, kind.length);
  std::ranges::fill(payload, std::byte{0});
  return payload;
}

}  // namespace

std::uint16_t crc16(std::span<const std::byte> bytes, std::uint16_t crc) noexcept {
  unsigned value = crc;
  for (const std::byte byte : bytes) {
    value ^= std::to_integer<unsigned>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      value = (value >> 1) ^ ((value & 1U) != 0 ? 0x8408U : 0U);  // 0x1021, reflected
    }
  }
  return static_cast<std::uint16_t>(value);
}

std::span<const std::byte> Writer::seal(const MessageKind& kind, Buffer& buffer) noexcept {
  const std::span<std::byte> bytes(buffer);
  // Zeros at the payload's end are not sent; one byte always is.
  std::size_t length = kind.length;
  while (length > 1 && bytes[kHeaderBytes + length - 1] == std::byte{0}) {
    --length;
  }
  put_u8(bytes.subspan<0, 1>(), kMagic);
  put_u8(bytes.subspan<1, 1>(), static_cast<std::uint8_t>(length));
  put_u16(bytes.subspan<2, 2>(), 0);  // neither signed nor anything else
  put_u8(bytes.subspan<4, 1>(), sequence_++);
  put_u8(bytes.subspan<5, 1>(), system_);
  put_u8(bytes.subspan<6, 1>(), component_);
  put_u16(bytes.subspan<7, 2>(), static_cast<std::uint16_t>(kind.id));
  put_u8(bytes.subspan<9, 1>(), static_cast<std::uint8_t>(kind.id >> 16));
  const std::array extra{std::byte{kind.crc_extra}};
  const std::uint16_t crc = crc16(extra, crc16(bytes.subspan(1, kHeaderBytes - 1 + length)));
  put_u16(bytes.subspan(kHeaderBytes + length).first<kCrcBytes>(), crc);
  return bytes.first(kHeaderBytes + length + kCrcBytes);
}

std::span<const std::byte> Writer::write(const Heartbeat& message, Buffer& buffer) noexcept {
  const std::span<std::byte> out = payload_of(kHeartbeatKind, buffer);
  put_u8(out.subspan<4, 1>(), kOnboardController);
  put_u8(out.subspan<5, 1>(), kNoAutopilot);
  put_u8(out.subspan<7, 1>(), static_cast<std::uint8_t>(message.state));
  put_u8(out.subspan<8, 1>(), kProtocolVersion);
  return seal(kHeartbeatKind, buffer);
}

std::span<const std::byte> Writer::write(const ObstacleDistance& message, Buffer& buffer) noexcept {
  const std::span<std::byte> out = payload_of(kObstacleDistanceKind, buffer);
  put_u64(out.subspan<0, 8>(), message.time_us);
  for (std::size_t i = 0; i < kDirections; ++i) {
    put_u16(out.subspan(8 + 2 * i).first<2>(), message.distances_cm[i]);
  }
  put_u16(out.subspan<152, 2>(), message.least_cm);
  put_u16(out.subspan<154, 2>(), message.most_cm);
  put_u8(out.subspan<156, 1>(), kUnknownSensor);
  put_u8(out.subspan<157, 1>(), 0);  // whole degrees: increment_deg says it
  put_float(out.subspan<158, 4>(), message.increment_deg);
  put_float(out.subspan<162, 4>(), message.angle_offset_deg);
  put_u8(out.subspan<166, 1>(), kBodyFrd);
  return seal(kObstacleDistanceKind, buffer);
}

std::span<const std::byte> Writer::write(const DistanceSensor& message, Buffer& buffer) noexcept {
  const std::span<std::byte> out = payload_of(kDistanceSensorKind, buffer);
  put_u32(out.subspan<0, 4>(), message.time_boot_ms);
  put_u16(out.subspan<4, 2>(), message.least_cm);
  put_u16(out.subspan<6, 2>(), message.most_cm);
  put_u16(out.subspan<8, 2>(), message.distance_cm);
  put_u8(out.subspan<10, 1>(), kUnknownSensor);
  put_u8(out.subspan<13, 1>(), message.variance_cm2);
  put_float(out.subspan<14, 4>(), message.horizontal_fov_rad);
  put_float(out.subspan<18, 4>(), message.vertical_fov_rad);
  put_u8(out.subspan<38, 1>(), message.quality);
  return seal(kDistanceSensorKind, buffer);
}

}  // namespace stof::firmware::mavlink

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

// How a PMD camera on USB speaks: docs/HARDWARE.md, "A PMD camera on USB".
namespace stof::hal::linux {

inline constexpr std::uint8_t kPmdInterfaceClass = 0xFF;
inline constexpr std::uint8_t kPmdInterfaceSubclass = 0x50;
inline constexpr std::uint8_t kPmdInterfaceProtocol = 0x01;
inline constexpr std::uint8_t kPmdEndpoint = 0x81;
inline constexpr std::uint8_t kPmdRequestIn = 0xC1;   // bmRequestType
inline constexpr std::uint8_t kPmdRequestOut = 0x41;  // bmRequestType

// bRequest
enum class PmdRequest : std::uint8_t {
  kInfo = 1,
  kClock = 2,
  kSetConfig = 3,
  kGetConfig = 4,
  kStream = 5,
};

inline constexpr std::size_t kPmdInfoBytes = 32;
inline constexpr std::size_t kPmdClockBytes = 8;
inline constexpr std::size_t kPmdConfigBytes = 16;
inline constexpr std::size_t kPmdHeaderBytes = 96;
inline constexpr std::size_t kPmdMostHeaderBytes = 512;  // of later versions
inline constexpr std::uint32_t kPmdInfoMagic = 0x444D5053;
inline constexpr std::uint32_t kPmdFrameMagic = 0x46444D50;
inline constexpr std::uint16_t kPmdVersion = 1;
inline constexpr int kPmdMostSide = 4096;  // pixels; larger ones are taken for damage
// A sample does not begin later than this after the edge, and is no longer.
inline constexpr std::uint32_t kPmdMostExposureNs = 1'000'000'000;

struct PmdInfo {
  int width = 0;   // 1 .. kPmdMostSide
  int height = 0;  // 1 .. kPmdMostSide
  int bits = 0;    // of a sample, 10 .. 15
  std::uint32_t least_khz = 0;
  std::uint32_t most_khz = 0;
  std::uint32_t least_integration_us = 0;  // of one sample
  std::uint32_t most_integration_us = 0;
  std::uint32_t serial = 0;

  friend bool operator==(const PmdInfo&, const PmdInfo&) = default;
};

struct PmdConfig {
  std::uint32_t modulation_khz = 0;
  std::uint32_t integration_us = 0;  // of one sample
  std::uint32_t delay_us = 0;        // from the edge to the first sample

  friend bool operator==(const PmdConfig&, const PmdConfig&) = default;
};

struct PmdSpan {
  std::uint32_t begin_ns = 0;  // after the edge
  std::uint32_t length_ns = 0;

  friend bool operator==(const PmdSpan&, const PmdSpan&) = default;
};

struct PmdHeader {
  static constexpr std::uint16_t kEdgeIgnored = 1;  // flags
  static constexpr std::uint16_t kTooWarm = 2;      // flags
  static constexpr std::int16_t kNoTemperature = 32767;

  std::uint32_t sequence = 0;
  std::uint16_t flags = 0;
  std::uint32_t modulation_khz = 0;
  std::uint64_t edge = 0;  // of the camera's clock, ns
  std::array<PmdSpan, 4> samples{};
  std::int16_t temperature = kNoTemperature;  // 1/100 degree C
  std::size_t bytes = kPmdHeaderBytes;        // the pictures begin here: even

  friend bool operator==(const PmdHeader&, const PmdHeader&) = default;
};

// Bytes of the four pictures.
constexpr std::size_t pmd_picture_bytes(const PmdInfo& info) noexcept {
  return static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height) *
         sizeof(std::uint16_t) * 4;
}

// Nothing: wrong length, magic, version or a number out of its range. Any bytes will do.
std::optional<PmdInfo> parse_pmd_info(std::span<const std::byte> bytes) noexcept;
std::optional<std::uint64_t> parse_pmd_clock(std::span<const std::byte> bytes) noexcept;
// `bytes` is a whole message of a camera that is as `info` says. Nothing also: another size or
// number of bits than its own, samples that overlap or are not in order, a message of another
// length than its header and pictures have. Flags that are not known are kept. Pixels are not
// looked at.
std::optional<PmdHeader> parse_pmd_frame(std::span<const std::byte> bytes,
                                         const PmdInfo& info) noexcept;

std::array<std::byte, kPmdConfigBytes> compose_pmd_config(const PmdConfig& config) noexcept;

}  // namespace stof::hal::linux

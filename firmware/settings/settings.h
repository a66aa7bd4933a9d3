#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "firmware/settings/text/fixed_text.h"
#include "firmware/wire/frame/frame_images.h"

// The settings of a sensor. The table in field.cpp says of each field which
// values it takes, its unit and what it means; the values below are the defaults.
namespace stof::settings {

inline constexpr std::size_t kNameBytes = 31;
inline constexpr std::size_t kDeviceBytes = 63;
inline constexpr std::size_t kMatchBytes = 23;
inline constexpr std::size_t kInterfaceBytes = 18;  // "255.255.255.255/30"
inline constexpr std::size_t kIpv4Bytes = 15;
inline constexpr std::size_t kHostnameBytes = 63;
// At least as many as dsp::match_options() has.
inline constexpr std::size_t kMatchSlots = 24;

// dsp::find_preset() of their names.
enum class DepthPreset : std::uint8_t { kFast, kQuality, kChapter };

// dsp::ThreadTeam::kMost.
inline constexpr int kMostThreads = 8;
inline constexpr int kUsualThreads = 4;

// The sensors without which there is no frame.
enum class RequiredSensors : std::uint8_t { kAny, kBoth };

struct DepthSettings {
  DepthPreset preset = DepthPreset::kFast;
  int max_range_mm = 10000;
  int disparities = 0;  // 0: what the rig asks for
  bool guided = false;
  bool temporal = false;
  RequiredSensors require = RequiredSensors::kAny;
  // By the place in dsp::match_options(); empty: as the preset has it.
  std::array<Text<kMatchBytes + 1>, kMatchSlots> match{};

  friend bool operator==(const DepthSettings&, const DepthSettings&) = default;
};

enum class SerialMode : std::uint8_t { kOff, kStof, kMavlink };
enum class SerialProfile : std::uint8_t { kSectors, kCoarse, kMedium };

struct SerialSettings {
  SerialMode mode = SerialMode::kOff;
  Text<kDeviceBytes + 1> device{};  // empty: no line
  int baud = 921'600;
  bool flow_control = false;  // RTS and CTS
  SerialProfile profile = SerialProfile::kSectors;
  int rate_hz = 10;
  bool width = false;   // the stream `width` beside depth
  bool remote = false;  // whoever is at its other end needs a key, as on the network

  friend bool operator==(const SerialSettings&, const SerialSettings&) = default;
};

// Which pixels make an obstacle.
struct SectorSettings {
  // Anything more than this above the camera is ignored; the robot passes below it.
  int above_mm = 300;
  int below_mm = 300;
  int pixels = 8;      // that make an obstacle, at least 1
  int least_mm = 100;  // obstacles nearer than that are reported at that distance

  friend bool operator==(const SectorSettings&, const SectorSettings&) = default;
};

struct MavlinkSettings {
  int system_id = 1;
  int component_id = 196;  // MAV_COMP_ID_OBSTACLE_AVOIDANCE

  friend bool operator==(const MavlinkSettings&, const MavlinkSettings&) = default;
};

struct ComputeSettings {
  int threads = 0;  // 0: as many as the board has processors, at most kUsualThreads

  friend bool operator==(const ComputeSettings&, const ComputeSettings&) = default;
};

struct DiscoverySettings {
  bool mdns = true;
  bool beacon = true;

  friend bool operator==(const DiscoverySettings&, const DiscoverySettings&) = default;
};

// Of the machine's interface, where it is the sensor's own (NetworkTrial).
struct NetworkSettings {
  bool dhcp = true;
  bool link_local = true;               // one of 169.254.0.0/16 where there is no other address
  Text<kInterfaceBytes + 1> address{};  // "A.B.C.D/BITS", beside that of DHCP; empty: none
  Text<kIpv4Bytes + 1> gateway{};       // empty: none but that of DHCP
  Text<kHostnameBytes + 1> hostname{"stof"};

  friend bool operator==(const NetworkSettings&, const NetworkSettings&) = default;
};

// What all streams may be changed to by whoever is not the admin.
enum class StreamLimit : std::uint8_t { kNone, kKeep, kFixed };

// The installer's: only an admin changes them, and nobody else leaves them.
struct LimitSettings {
  int least_range_mm = 1000;
  int least_period_ms = 0;  // 0: the board's own too
  int most_period_ms = 1000;
  StreamLimit streams = StreamLimit::kKeep;

  friend bool operator==(const LimitSettings&, const LimitSettings&) = default;
};

inline constexpr int kMostPeriodMs = 60'000;

struct Settings {
  Text<kNameBytes + 1> name{"stof"};
  int period_ms = 0;  // 0: the board's
  bool standby = false;
  DepthSettings depth;
  wire::StreamChoice streams{
      .coding = {wire::Coding::kQuantised, wire::Coding::kQuantised, wire::Coding::kRvl}};
  int pace_percent = 60;  // of a period, that sending is spread over
  int udp_port = 7560;
  int dscp = 0;  // of every datagram
  SerialSettings serial;
  SectorSettings sectors;
  MavlinkSettings mavlink;
  DiscoverySettings discovery;
  NetworkSettings network;
  ComputeSettings compute;
  LimitSettings limits;

  friend bool operator==(const Settings&, const Settings&) = default;
};
static_assert(std::is_trivially_copyable_v<Settings>);

}  // namespace stof::settings

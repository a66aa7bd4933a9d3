#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "tests/campaign/world.h"

namespace stof::campaign {

// Where in the sensor's life a fault begins.
enum class Place : std::uint8_t { kStart, kSteady, kMidFrame };
inline constexpr std::size_t kPlaces = 3;

// What goes wrong in one run, and how the moments of it are known: those of a fault by calls are
// read from the devices' own logs.
struct Plan {
  enum class By : std::uint8_t { kTime, kTriggerCalls, kStereoCalls, kPmdCalls, kLinkCalls };

  hal::Time base{std::chrono::seconds(1000)};  // before it is made: the begin of the run

  CallFaults calls{};
  By by = By::kTime;
  emu::Fault fault{};  // the one in `calls`
  Span span{};         // of everything else

  TimedFault trigger{};
  TimedFault stereo{};
  TimedFault pmd{};
  TimedFault link{};
  std::optional<netem::ImpairmentOptions> network{};
  Attack attack = Attack::kNone;
  bool stops_sensor = false;
  bool stops_robot = false;
  bool power_off = false;
  hal::Duration busy{};       // every look at the clock takes up to that
  hal::Duration wall_jump{};  // of the robot's wall clock
};

struct Kind {
  const char* group;
  const char* name;
  void (*make)(Plan& plan, Place place, test::Random& random);
};
std::span<const Kind> kinds() noexcept;

// What of a plan is not known to the devices from the start.
void arm(World& world, const Plan& plan);

// What a run showed. Times in milliseconds.
struct Verdict {
  // Whether the robot went without a whole, true frame for longer than three periods and 20 ms.
  // What costs less is no more than a late frame.
  bool effect = false;
  // From the last whole frame before the effect to the first sign of it; none: no sign.
  std::optional<double> detected_ms{};
  std::optional<double> told_ms{};  // the same, to the first word of sensor or libstof
  double outage_ms = 0;             // the longest time without a whole, true frame
  double healed_ms = 0;             // from the fault's end until all is well for good
  double oldest_ms = 0;             // the oldest frame delivered
  std::uint64_t delivered = 0;
  std::array<std::uint64_t, kFalsehoods> falsehoods{};

  bool in_time() const noexcept;
  bool was_told() const noexcept;
  bool healed() const noexcept;
  std::uint64_t false_frames() const noexcept;
};

Verdict run(const Kind& kind, Place place, std::uint64_t seed);

// Whether the judge that all this relies on finds other pixels and frames of the past in robots
// that take them, and nothing where nothing is wrong.
bool check_the_judge();

}  // namespace stof::campaign

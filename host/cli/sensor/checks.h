#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "firmware/wire/messages/calibration.h"
#include "host/cli/live/frame_wait.h"
#include "host/cli/sensor/health.h"
#include "host/cli/sensor/network_facts.h"
#include "host/cli/sensor/stats.h"
#include "host/discovery/found_sensors.h"

namespace stof::host {

// What `stof check` found out, before it is judged. Of a recording only what it can tell.
struct CheckFacts {
  bool recorded = false;
  std::string sensor{};  // as the user calls it
  std::optional<client::FoundSensor> identity{};
  std::string no_identity{};  // why
  bool sending_refused = false;
  bool nobody_listens = false;  // the sensor's computer says so
  bool subscribed = false;
  bool all_places_taken = false;
  bool beacon_heard = false;
  StreamStats stats{};
  Comes comes = Comes::kFrames;                    // at the end
  std::optional<client::Duration> silent_since{};  // age of the last frame then, where none comes
  bool forged_traffic = false;  // it was told, of a sensor in the last two seconds
  std::optional<HealthState> health{};
  std::optional<wire::CalibrationPacket> calibration{};
  bool lenses_contradict = false;         // of a recording: recording::ToldLenses
  std::uint64_t frames_without_lens = 0;  // of a recording
  bool other_calibration = false;         // frames name another one than that which came
  std::string drift{};                    // as drift_text()
  wire::ClockState clock = wire::ClockState::kMonotonic;
  NetworkFacts network{};
  int buffer = 0;         // bytes that the system granted
  int asked_buffer = 0;   // bytes
  std::string version{};  // of this program
};

enum class CheckVerdict : std::uint8_t {
  kOk,
  kNote,  // nothing has to be done, or nobody can tell
  kFix,   // do what `fix` says
};

struct Check {
  std::string name{};  // link, mtu, ...
  CheckVerdict verdict = CheckVerdict::kOk;
  std::string found{};
  std::string fix{};  // one line; empty: nothing to do
};

// Each check once, in the order in which they should be mended: what is first may be why the next
// ones fail.
std::vector<Check> judge_checks(const CheckFacts& facts);

CheckVerdict worst_of(const std::vector<Check>& checks);
std::string checks_text(const std::vector<Check>& checks);
nlohmann::ordered_json checks_json(const std::string& source, const std::vector<Check>& checks);

}  // namespace stof::host

// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/messages/enums.h"

namespace stof::wire {

inline constexpr std::size_t kConditions = 15;

// What can be wrong; values travel in events and, as bits, in health.
enum class Condition : std::uint8_t {
  kNoFrames = 0,     // several edges in a row without a frame; value: edges so far
  kTriggerLost = 1,  // the trigger line is gone; value: 0
  kStereoLost = 2,   // a stereo camera is gone; value: 0
  kPmdLost = 3,      // the PMD camera is gone; value: 0
  kLate = 4,         // the computer is too slow: periods were skipped; value: periods skipped
  kLinkLost = 5,     // the network port failed; value: 0
  kUnreachable = 6,  // datagrams do not leave: nobody can be reached; value: 0
  kLinkFull = 7,  // the network does not take all datagrams: send less, or raise the port's buffer;
                  // value: datagrams dropped in this second
  kDrift = 8,  // the rig has drifted from its calibration: calibrate it anew; value: bit k: drift k
               // is significant
  kSerialLost = 9,   // the serial port failed; value: 0
  kSerialFull = 10,  // the serial line is too slow for its profile and rate; value: frames dropped
                     // in this second
  kSettingsUnsaved = 11,  // the settings could not be saved; value: 0
  kRestartNeeded = 12,    // some settings wait for the next start; value: 0
  kFlooded = 13,  // more than 1,000 refused requests in a second; value: refused in this second
  kSettingsFellBack = 14,  // settings named what this version has not: these fields are as the
                           // preset has them, until the settings are saved; value: 0
};

struct ConditionInfo {
  const char* name;  // snake case
  const char* text;  // for people
  Severity severity;
  Reaction reaction;  // of the robot while it is active
};

// nullptr: a condition this code does not know.
const ConditionInfo* info_of(Condition condition) noexcept;

}  // namespace stof::wire

// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/conditions.h"

namespace stof::wire {

namespace {

constexpr std::array<ConditionInfo, kConditions> kInfos{{
    {"no_frames", "several edges in a row without a frame", Severity::kCritical, Reaction::kStop},
    {"trigger_lost", "the trigger line is gone", Severity::kCritical, Reaction::kStop},
    {"stereo_lost", "a stereo camera is gone", Severity::kCritical, Reaction::kStop},
    {"pmd_lost", "the PMD camera is gone", Severity::kCritical, Reaction::kStop},
    {"late", "the computer is too slow: periods were skipped", Severity::kMajor, Reaction::kSlow},
    {"link_lost", "the network port failed", Severity::kMajor, Reaction::kNone},
    {"unreachable", "datagrams do not leave: nobody can be reached", Severity::kMinor,
     Reaction::kNone},
    {"link_full", "the network does not take all datagrams: send less, or raise the port's buffer",
     Severity::kMajor, Reaction::kSlow},
    {"drift", "the rig has drifted from its calibration: calibrate it anew", Severity::kMajor,
     Reaction::kWatch},
    {"serial_lost", "the serial port failed", Severity::kMajor, Reaction::kNone},
    {"serial_full", "the serial line is too slow for its profile and rate", Severity::kMinor,
     Reaction::kNone},
    {"settings_unsaved", "the settings could not be saved", Severity::kMinor, Reaction::kWatch},
    {"restart_needed", "some settings wait for the next start", Severity::kInfo, Reaction::kNone},
    {"flooded", "more than 1,000 refused requests in a second", Severity::kMinor, Reaction::kWatch},
    {"settings_fell_back",
     "settings named what this version has not: these fields are as the preset has them, until the "
     "settings are saved",
     Severity::kMinor, Reaction::kWatch},
}};

}  // namespace

const ConditionInfo* info_of(Condition condition) noexcept {
  const auto at = static_cast<std::size_t>(condition);
  return at < kInfos.size() ? &kInfos[at] : nullptr;
}

}  // namespace stof::wire

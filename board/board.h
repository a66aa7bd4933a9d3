#pragma once

#include <expected>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/base/status.h"
#include "dsp/calib/calibration.h"
#include "hal/clock.h"
#include "hal/link.h"
#include "hal/pmd_camera.h"
#include "hal/stereo_camera.h"
#include "hal/time.h"
#include "hal/trigger.h"

// Which board this is was chosen at link time; its table kConfig by the build.
#include STOF_BOARD_CONFIG

namespace stof::board {

// The devices of a board that is open, and what is known about the rig in front of it.
struct Board {
  hal::Clock& clock;
  hal::Trigger& trigger;
  hal::StereoCamera& stereo;
  hal::PmdCamera* pmd;  // nullptr: this rig has none, depth comes from stereo alone
  hal::Link& link;
  dsp::Calibration calibration;
  int disparities;     // search range that the rig asks for
  bool emulated_time;  // the clock is not this machine's
  std::vector<std::string>
      notes;  // lines that whoever started it should read, such as what is missing
};

// A request that a board could not fulfil: one line, what, where and what to do.
struct Refusal {
  std::string message;
  bool device = false;  // the request was fine, a device failed
};

// Opens the devices; may allocate and take a second or two. `arguments` are the board's own command
// line flags (after the common ones were taken out); unknown ones are refused. The board lives
// until the program ends; call once.
std::expected<Board*, Refusal> open(std::span<const std::string_view> arguments);

// Opens again, in place, what returned kDeviceLost; may allocate, and block for up to a second.
// kOk: go on. kDeviceLost: not back yet, try again later. What is open stays as it is.
Status reopen(Board& board) noexcept;

// The board's own flags, one per line, for --help.
std::string_view usage() noexcept;

}  // namespace stof::board

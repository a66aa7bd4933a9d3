#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <string>
#include <vector>

#include "board/board.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/publisher.h"
#include "firmware/serial/serial_params.h"
#include "firmware/settings/settings.h"
#include "firmware/workspace.h"

// From the board's table, the rig and the settings to what the loop runs with. Not for the loop's
// thread; may allocate. Errors: one line, what, where and what to do.
namespace stof::firmware {

// The constants from start to end.
struct RigInfo {
  dsp::Calibration calibration;             // PMD size 0x0: none
  std::vector<std::int16_t> fixed_pattern;  // what calibration.pmd.fixed_pattern refers to
  int disparities = 0;                      // that the rig asks for
  std::string calibration_file;             // empty: the board's own
  int threads = 1;                          // there are to compute depth
  hal::Duration least_period{};             // that its cameras' frames can be told apart with
};

// calibration_file: replaces the board's calibration; empty: that holds.
std::expected<RigInfo, std::string> make_rig(const board::Board& board, const board::Config& config,
                                             const std::string& calibration_file);

// The configuration that settings make of a rig. Refers to the rig's fixed pattern.
struct RunConfig {
  Setup setup;
  board::TimingConfig timing;
  PublisherParams publisher;
  SerialParams serial;
  std::size_t image_bytes = 0;  // of memory that the pipeline of this setup takes
};

// As many of the rig's threads as there is room for, bytes for images: each searches in memory of
// its own. An error where the board has no room for these settings, or no use.
std::expected<RunConfig, std::string> make_run_config(const RigInfo& rig,
                                                      const board::Config& config,
                                                      const settings::Settings& settings,
                                                      std::size_t room = sizeof(Workspace::memory));

}  // namespace stof::firmware

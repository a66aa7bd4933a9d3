#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <string>
#include <vector>

#include "board/board.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/publisher.h"
#include "firmware/program/rig_calibration.h"
#include "firmware/serial/serial_params.h"
#include "firmware/settings/settings.h"
#include "firmware/workspace.h"

// From the board's table, the rig and the settings to what the loop runs with. Not for the loop's
// thread; may allocate. Errors: one line, what, where and what to do.
namespace stof::firmware {

// Why an installed calibration is not used; the value of condition `calibration_dropped`.
enum class CalibrationDropped : std::uint8_t { kNot, kUnreadable, kUnusable };

// The constants from start to end, but for the calibration, which another one may take the place of
// (CalibrationInstaller).
struct RigInfo {
  dsp::Calibration calibration;  // PMD size 0x0: none
  // What calibration.pmd.fixed_pattern refers to; empty: memory of the board.
  std::vector<std::int16_t> fixed_pattern;
  std::uint32_t fingerprint = 0;  // of the calibration's file
  std::uint32_t installs = 0;     // how often it changed since the start
  CalibrationDropped dropped = CalibrationDropped::kNot;
  bool installed = false;  // it is not the factory's
  std::vector<std::byte>
      factory;                   // file of what holds where none is installed; empty: there is none
  RigNeeds needs;                // of any other
  int disparities = 0;           // that the rig asks for
  int threads = 1;               // there are to compute depth
  hal::Duration least_period{};  // that its cameras' frames can be told apart with
};

// The calibration that was put on the sensor, as the start found it.
struct InstalledCalibration {
  std::string place;            // its file's name, for messages
  std::vector<std::byte> file;  // empty: there is none
  bool unreadable = false;
};

// calibration_file: the factory's calibration, in place of the board's own; empty: that is it. An
// installed one holds in place of either; where it cannot be used the factory's does, and `note`
// says so in one line.
std::expected<RigInfo, std::string> make_rig(const board::Board& board, const board::Config& config,
                                             const std::string& calibration_file,
                                             const InstalledCalibration& installed,
                                             std::string& note);

// The configuration that settings make of a rig. Refers to the rig's fixed pattern.
struct RunConfig {
  Setup setup;
  board::TimingConfig timing;
  PublisherParams publisher;
  SerialParams serial;
  wire::CalibrationPacket calibration{};  // as receivers get it
  std::uint32_t installs = 0;             // RigInfo::installs
  bool standby = false;                   // no edges while nobody receives
  std::size_t image_bytes = 0;            // of memory that the pipeline of this setup takes
};

// As many of the rig's threads as there is room for, bytes for images: each searches in memory of
// its own. An error where the board has no room for these settings, or no use.
std::expected<RunConfig, std::string> make_run_config(const RigInfo& rig,
                                                      const board::Config& config,
                                                      const settings::Settings& settings,
                                                      std::size_t room = sizeof(Workspace::memory));

}  // namespace stof::firmware

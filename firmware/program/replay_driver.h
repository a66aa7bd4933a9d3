#pragma once

#include <expected>
#include <string>

#include "board/board.h"
#include "firmware/program/appliance.h"
#include "firmware/program/options.h"
#include "firmware/program/run_config.h"
#include "firmware/settings/settings.h"

namespace stof::firmware {

// Runs the loop through a recording: with its settings, which change before the frame before which
// they did, and from its states. Host builds alone; allocates.
class ReplayDriver {
 public:
  // The settings of the recording's begin: how depth is computed, the period and the streams; on
  // top of them those of the command line, and the rest of `own`. Error: one line.
  static std::expected<settings::Settings, std::string> first_settings(
      const board::Replay& replay, const settings::Settings& own, const Options& options);
  // This board's, with the timing of the recording.
  static board::Config config(const board::Board& board);

  // All outlive it. The loop begins with first_settings(). own: as there.
  ReplayDriver(board::Replay& replay, const RigInfo& rig, const board::Config& config,
               const settings::Settings& own, const Options& options);

  // Before each step(): what changed before the next edge. False: the recording is over.
  bool prepare(Appliance& appliance);
  // Why it is over before its end, in a line; else empty.
  const std::string& problem() const noexcept { return problem_; }

 private:
  void note_streams(const settings::Settings& recorded);

  board::Replay& replay_;
  const RigInfo& rig_;
  const board::Config& config_;
  const settings::Settings& own_;
  const Options& options_;
  std::uint32_t revision_ = 1;
  std::string problem_;
};

}  // namespace stof::firmware

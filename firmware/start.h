#pragma once

#include <expected>
#include <string>
#include <vector>

#include "board/board.h"
#include "firmware/options.h"
#include "firmware/pipeline.h"

// From the board's table, the rig and the command line to what the loop runs with. Used once,
// before the loop; may allocate. Errors: one line, what, where and what to do.
namespace stof::firmware {

struct Start {
  Setup setup;
  board::TimingConfig timing;
  std::vector<std::int16_t> fixed_pattern;  // what setup.calibration.pmd.fixed_pattern refers to
};

std::expected<Start, std::string> make_start(const board::Board& board, const board::Config& config,
                                             const Options& options);

}  // namespace stof::firmware

#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/dataset.h"
#include "hal/emu/imagery/board_motion.h"
#include "hal/emu/imagery/moving_scene.h"
#include "hal/emu/scenes/boards.h"
#include "hal/emu/scenes/poses.h"
#include "hal/emu/scenes/rig.h"

// Boards that are held before the emulated rig, by their flags.
namespace stof::board {

struct BoardOptions {
  std::optional<hal::emu::PoseScript> poses;  // none: what suits the board
  double speed_m_s = 0;
  double turn_degrees_s = 0;
  int hold = 30;  // exposures at each pose, where the board is shown live
  int moves = 1;  // exposures on the way to the next
};

// Takes one of the flags of board_usage(). false: the flag is none of them. A line: its value means
// nothing.
std::expected<bool, std::string> take_board_flag(std::string_view flag, std::string_view value,
                                                 BoardOptions& options);
// These flags, one per line, for --help.
std::string_view board_usage() noexcept;

// What the emulated PMD camera shines less before such a board, so that a near one does not
// saturate it.
double board_light(std::string_view scene) noexcept;

// A rig before a board: looks along z from the origin, with enough rays for edges in amplitude.
hal::emu::Rig board_rig();

// A board before a rig, and its truth: a pose for each folder.
struct BoardWorld {
  std::unique_ptr<hal::emu::MovingScene> imagery;
  dataset::CalibrationTruth truth;
  std::vector<std::optional<double>> plane_z_m;  // of each pose that is perpendicular to z
};
// hold, moves: as BoardTimes has them. The board must be one (parse_board()).
BoardWorld board_world(const hal::emu::Board& board, const hal::emu::Rig& rig,
                       const BoardOptions& options, const hal::emu::BoardTimes& times);

}  // namespace stof::board

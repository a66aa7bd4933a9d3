#pragma once

#include <vector>

#include "hal/emu/imagery/driven_scene.h"
#include "hal/emu/imagery/moving_scene.h"
#include "hal/emu/scenes/boards.h"
#include "hal/emu/scenes/poses.h"
#include "hal/emu/scenes/rig.h"

namespace stof::hal::emu {

// How long a board is held, and how it comes to the next pose, in exposures of the pair.
struct BoardTimes {
  ExposureTimes exposures{};
  int hold = 1;   // at each pose, 1 or more
  int moves = 0;  // on the way to the next one, and from the last to the first; 0: it jumps
};

// A board that is held before a rig, pose after pose, round and round. What a pose's own velocity
// and the way to the next one do within an exposure is blurred: of the pair in as many parts as the
// board moves half pixels, 2 to 16. On the way to the next pose these are 4 at most, and the PMD
// camera's four samples see one moment: nobody measures there, and each part takes its time.
Motion board_motion(const Board& board, const std::vector<BoardPose>& poses, const Rig& rig,
                    const BoardTimes& times);

}  // namespace stof::hal::emu

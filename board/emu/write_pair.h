#pragma once

#include <span>
#include <string_view>

namespace stof::board {

// stof_emu_pair DIR [flags]: one exposure of an emulated scene as a recorded one in the folder DIR,
// which is made where missing: the stereo pair, its exact disparities, what both cameras see, the
// rig; and, where the rig has a PMD camera, its recording DIR/pmd, of one frame or more.
// `arguments` without the program's name. Returns the exit code: 0, or 2 after one line on stderr.
int write_pair(std::span<const std::string_view> arguments);

}  // namespace stof::board

#pragma once

#include <cstdint>
#include <string>

#include "dataset/image.h"
#include "host/calibrate/rig/live/view_guide.h"

namespace stof::host {

// How well corners are looked for: find_board_roughly() or find_board().
enum class Corners : std::uint8_t { kRough, kFine };

// The board in both pictures of one exposure. lens: of both eyes, roughly. name: of
// the view that it may become.
Sighting sighting_of(const dataset::Image<std::uint8_t>& left,
                     const dataset::Image<std::uint8_t>& right, const Board& board,
                     const dsp::Pinhole& lens, std::string name, Corners how);
// The same of corners that are known.
Sighting sighting_of(PairView corners, const Board& board, const dsp::Pinhole& lens);

// For guidance where nobody tells a lens: a field of 60 degrees.
dsp::Pinhole assumed_lens(int width, int height);

}  // namespace stof::host

#pragma once

#include "dataset/image.h"
#include "host/calibrate/rig/live/view_guide.h"

namespace stof::host {

// The board in both pictures of one exposure (find_board()). lens: of both eyes, roughly. name: of
// the view that it may become.
Sighting sighting_of(const dataset::Image<std::uint8_t>& left,
                     const dataset::Image<std::uint8_t>& right, const Board& board,
                     const dsp::Pinhole& lens, std::string name);
// The same of corners that are known.
Sighting sighting_of(PairView corners, const Board& board, const dsp::Pinhole& lens);

// For guidance where nobody tells a lens: a field of 60 degrees.
dsp::Pinhole assumed_lens(int width, int height);

}  // namespace stof::host

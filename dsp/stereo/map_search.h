#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"

// The searches that need the whole picture at once: blocks of their own shape, coarse to fine.
namespace stof::dsp {

// Whether these parameters ask for one of them.
bool searches_map(const MatchParams& params) noexcept;

// What search_map() takes from its Arena.
std::size_t search_map_bytes(const MatchParams& params, int width, int height) noexcept;

// The candidates of all pixels, with the left-right check where it is asked for; kNoWinner where
// there is none. winners: of the pair's size.
void search_map(const MatchParams& params, const PreparedPair& pair, Arena arena,
                ImageView<std::int16_t> winners) noexcept;

}  // namespace stof::dsp

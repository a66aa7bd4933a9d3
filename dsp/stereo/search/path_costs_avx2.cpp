#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/search/path_costs_body.h"

namespace stof::dsp::avx2 {

STOF_INSTANTIATE(PathsAlong, paths_along, std::uint16_t);
STOF_INSTANTIATE(PathsBothWays, paths_both_ways, std::uint8_t, std::uint16_t);
STOF_INSTANTIATE(PathsAcross, paths_across, std::uint8_t, std::uint16_t);
STOF_INSTANTIATE(PathsOfAxes, paths_of_axes, std::uint8_t, std::uint16_t);

}  // namespace stof::dsp::avx2

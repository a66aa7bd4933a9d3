#include "dsp/stereo/search/semi_global.h"

#include "dsp/stereo/search/semi_global_body.h"

namespace stof::dsp {

template class SemiGlobal<std::uint8_t, std::uint8_t>;

}  // namespace stof::dsp

#include "dsp/stereo/cost/sad.h"

#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/cost/row_pairs_neon.h"

namespace stof::dsp::neon {

template <typename Sum>
void add_differences(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                     int lanes, std::span<Sum> columns) noexcept {
  add_rows(left, right, lanes, columns, Lanes<std::uint8_t>::difference);
}

STOF_INSTANTIATE(AddDifferences, add_differences, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon

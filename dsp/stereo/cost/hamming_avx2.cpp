#include "dsp/stereo/cost/hamming.h"

#include "dsp/stereo/cost/hamming_avx2.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Hamming {};

}  // namespace

void hamming_costs(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                   int bits, int lanes, std::span<std::uint8_t> costs) noexcept {
  if (lanes % static_cast<int>(Isa::kLanes) != 0) {
    neon::hamming_costs(left, right, bits, lanes, costs);
    return;
  }
  hamming_body::costs_of<Isa>(left, right, bits, lanes, costs);
}

}  // namespace stof::dsp::avx2

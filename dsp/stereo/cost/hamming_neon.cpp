#include "dsp/stereo/cost/hamming.h"

#include "dsp/stereo/cost/hamming_neon.h"

namespace stof::dsp::neon {
namespace {

struct Isa : Hamming {};

}  // namespace

void hamming_costs(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                   int bits, int lanes, std::span<std::uint8_t> costs) noexcept {
  hamming_body::costs_of<Isa>(left, right, bits, lanes, costs);
}

}  // namespace stof::dsp::neon

#include "dsp/stereo/cost/hamming.h"

#include <cstddef>

#include "dsp/base/simd.h"
#include "dsp/stereo/cost/hamming_body.h"
#include "dsp/stereo/cost/hamming_neon.h"

namespace stof::dsp::neon {
namespace {

struct Isa {
  using V = uint8x16_t;
  using Planes = neon::Planes;
  static constexpr std::size_t kLanes = 16;

  template <std::size_t kPlanes, std::size_t kVectors>
  static void distances(Planes left, Planes right, V (&out)[kVectors]) noexcept {
    hamming_distances<kPlanes>(left, right, out);
  }
  static void store(std::uint8_t* p, V v) noexcept { vst1q_u8(p, v); }
};

}  // namespace

void hamming_costs(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                   int bits, int lanes, std::span<std::uint8_t> costs) noexcept {
  hamming_body::costs_of<Isa>(left, right, bits, lanes, costs);
}

}  // namespace stof::dsp::neon

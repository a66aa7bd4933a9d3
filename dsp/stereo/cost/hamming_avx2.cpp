#include "dsp/stereo/cost/hamming.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/stereo/cost/hamming_avx2.h"
#include "dsp/stereo/cost/hamming_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa {
  using V = u8x32;
  using Planes = avx2::Planes;
  static constexpr std::size_t kLanes = 32;

  template <std::size_t kPlanes, std::size_t kVectors>
  [[gnu::always_inline]] static void distances(Planes left, Planes right,
                                               V (&out)[kVectors]) noexcept {
    hamming_distances<kPlanes>(left, right, out);
  }
  static void store(std::uint8_t* p, V v) noexcept { avx2::store(p, v); }
};

}  // namespace

void hamming_costs(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                   int bits, int lanes, std::span<std::uint8_t> costs) noexcept {
  if (lanes % 32 != 0) {
    neon::hamming_costs(left, right, bits, lanes, costs);
    return;
  }
  hamming_body::costs_of<Isa>(left, right, bits, lanes, costs);
}

}  // namespace stof::dsp::avx2

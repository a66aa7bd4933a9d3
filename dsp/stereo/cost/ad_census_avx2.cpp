#include "dsp/stereo/cost/ad_census_body.h"
#include "dsp/stereo/cost/hamming_avx2.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Hamming {
  // Bytes have no shift.
  static V half(V a) noexcept {
    return as<V>(_mm256_and_si256(_mm256_srli_epi16(bits(a), 1), _mm256_set1_epi8(0x7f)));
  }
};

}  // namespace

void ad_census_costs(const AdCensusRow& left, const AdCensusRow& right, int lanes,
                     std::span<std::uint8_t> costs) noexcept {
  if (lanes % static_cast<int>(Isa::kLanes) != 0) {
    neon::ad_census_costs(left, right, lanes, costs);
    return;
  }
  ad_census_body::costs_of<Isa>(left, right, lanes, costs);
}

}  // namespace stof::dsp::avx2

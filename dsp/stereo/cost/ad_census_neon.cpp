#include "dsp/stereo/cost/ad_census_body.h"
#include "dsp/stereo/cost/hamming_neon.h"

namespace stof::dsp::neon {
namespace {

struct Isa : Hamming {
  static V half(V a) noexcept { return vshrq_n_u8(a, 1); }
};

}  // namespace

void ad_census_costs(const AdCensusRow& left, const AdCensusRow& right, int lanes,
                     std::span<std::uint8_t> costs) noexcept {
  ad_census_body::costs_of<Isa>(left, right, lanes, costs);
}

}  // namespace stof::dsp::neon

#include "dsp/base/lanes_avx2.h"
#include "dsp/fusion/temporal/temporal_row_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Lanes<std::uint16_t> {};

}  // namespace

void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                  const TemporalState& state) noexcept {
  temporal_row_body::temporal_row<Isa>(row, limits, state, neon::temporal_row);
}

}  // namespace stof::dsp::avx2

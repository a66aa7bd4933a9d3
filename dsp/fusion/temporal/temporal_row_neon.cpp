#include "dsp/base/lanes_neon.h"
#include "dsp/fusion/temporal/temporal_row_body.h"

namespace stof::dsp::neon {
namespace {

struct Isa : Lanes<std::uint16_t> {};

}  // namespace

void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                  const TemporalState& state) noexcept {
  temporal_row_body::temporal_row<Isa>(row, limits, state, ref::temporal_row);
}

}  // namespace stof::dsp::neon

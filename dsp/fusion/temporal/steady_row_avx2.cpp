#include "dsp/base/lanes_avx2.h"
#include "dsp/fusion/temporal/steady_row_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Lanes<std::uint16_t> {};

}  // namespace

void steady_row(const SteadyRow& row, const SteadyLimits& limits,
                const SteadyState& state) noexcept {
  steady_row_body::steady_row<Isa>(row, limits, state, neon::steady_row);
}

}  // namespace stof::dsp::avx2

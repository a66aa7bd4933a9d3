#include "dsp/base/lanes_neon.h"
#include "dsp/fusion/temporal/steady_row_body.h"

namespace stof::dsp::neon {
namespace {

struct Isa : Lanes<std::uint16_t> {};

}  // namespace

void steady_row(const SteadyRow& row, const SteadyLimits& limits,
                const SteadyState& state) noexcept {
  steady_row_body::steady_row<Isa>(row, limits, state, ref::steady_row);
}

}  // namespace stof::dsp::neon

#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/cost/arms_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Lanes<std::uint8_t> {};

}  // namespace

void arms_along(std::span<const std::uint8_t> row, const ArmParams& params,
                std::span<std::uint8_t> left, std::span<std::uint8_t> right) noexcept {
  arms_body::along<Isa>(row, params, left, right);
}

void arms_across(std::span<const std::uint8_t> row, std::span<const std::uint8_t* const> others,
                 const ArmParams& params, std::span<std::uint8_t> arms) noexcept {
  arms_body::across<Isa>(row, others, params, arms, neon::arms_across);
}

}  // namespace stof::dsp::avx2

#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/cost/census_body.h"

namespace stof::dsp::neon {
namespace {

struct Isa : Lanes<std::uint8_t> {
  using Signed = int8x16_t;
  static Signed load_signed(const std::uint8_t* p) noexcept {
    return vreinterpretq_s8_u8(load(p) ^ all(128));
  }
  static V darker(Signed a, Signed b) noexcept { return vcltq_s8(a, b); }
};

}  // namespace

void census_5x5(std::span<const std::span<const std::uint8_t>, 5> rows,
                std::span<std::uint8_t> planes) noexcept {
  census_body::census<Isa, kCensus5x5>(rows, planes);
}
void census_7x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  census_body::census<Isa, kCensus7x7>(rows, planes);
}
void census_9x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  census_body::census<Isa, kCensus9x7>(rows, planes);
}

}  // namespace stof::dsp::neon

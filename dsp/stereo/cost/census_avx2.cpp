#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/cost/census_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Lanes<std::uint8_t> {
  using Signed = i8x32;
  static Signed load_signed(const std::uint8_t* p) noexcept {
    return as<i8x32>(bits(load(p) ^ all(128)));
  }
  static V darker(Signed a, Signed b) noexcept { return as<V>(bits(a < b)); }
};

}  // namespace

void census_5x5(std::span<const std::span<const std::uint8_t>, 5> rows,
                std::span<std::uint8_t> planes) noexcept {
  if (rows[0].size() < Isa::kLanes) {
    neon::census_5x5(rows, planes);
    return;
  }
  census_body::census<Isa, kCensus5x5>(rows, planes);
}
void census_7x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  if (rows[0].size() < Isa::kLanes) {
    neon::census_7x7(rows, planes);
    return;
  }
  census_body::census<Isa, kCensus7x7>(rows, planes);
}
void census_9x7(std::span<const std::span<const std::uint8_t>, 7> rows,
                std::span<std::uint8_t> planes) noexcept {
  if (rows[0].size() < Isa::kLanes) {
    neon::census_9x7(rows, planes);
    return;
  }
  census_body::census<Isa, kCensus9x7>(rows, planes);
}

}  // namespace stof::dsp::avx2

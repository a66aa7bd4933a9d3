#pragma once

#include <cstdint>

namespace stof::dsp {

inline constexpr std::int64_t kLightMmPerSecond = 299'792'458'000;
inline constexpr double kLightMetresPerSecond = 299'792'458.0;

struct Hertz {
  std::uint32_t value = 0;
};

struct RangeMm {
  std::uint32_t value = 0;
};

// c / (2 f): one turn of phase is half a wavelength. Rounded down to whole millimetres.
constexpr RangeMm unambiguous_range(Hertz modulation) noexcept {
  return {static_cast<std::uint32_t>(kLightMmPerSecond / (2 * std::int64_t{modulation.value}))};
}
static_assert(unambiguous_range(Hertz{20'000'000}).value == 7494);

}  // namespace stof::dsp

#pragma once

#include <array>
#include <cstdint>

#include "dsp/base/fixed.h"
#include "dsp/fusion/unwrap/wrap_maps.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

// How much light can come back from how far. A surface returns reflectance / r^2; reflectance is
// counted as twice the amplitude times the square of the distance in 4 mm.
class AmplitudeBound {
 public:
  // Highlights, harmonics of the light and a white that was measured too dark stay below this.
  static constexpr double kMargin = 1.5;
  // Without white_lsb: how much brighter than what stereo has decided a surface may be.
  static constexpr int kUnknownMargin = 4;

  explicit AmplitudeBound(double white_lsb) noexcept;

  bool known() const noexcept { return brightest_ != 0; }
  // A frame begins. range: after how much readings repeat.
  void start(const PmdMaps& maps) noexcept;
  std::uint32_t amp2(std::uint16_t measured) const noexcept;

  // Nothing at this distance returns so much, less three sigma.
  bool excludes(const Reading& reading, std::uint32_t distance) const noexcept;

  // Without white_lsb: learns from readings whose distance is known, and what then is too bright.
  void learn(const Reading& reading, std::uint32_t distance) noexcept;
  bool outshines(const Reading& reading, std::uint32_t distance) const noexcept;
  // Sets the bound to the 63/64 quantile of the learnt reflectances; 0 if none.
  void end_learning() noexcept;

 private:
  static constexpr int kClasses = 256;  // a quarter of a power of two each

  std::uint64_t brightest_;  // reflectance; 0 = unknown
  std::uint64_t learnt_ = 0;
  std::uint32_t range_ = 1;
  std::uint32_t integration_ = kReferenceIntegration;
  std::array<std::uint32_t, kClasses> classes_{};
};

}  // namespace stof::dsp

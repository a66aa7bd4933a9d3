#include "dsp/fusion/temporal/pixel_change.h"

#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void pixel_change(std::span<const std::uint8_t> now, std::span<std::uint8_t> then,
                  std::span<std::uint8_t> changed) noexcept {
  STOF_CHECK(now.size() == changed.size() && then.size() == changed.size());
  for (std::size_t x = 0; x < changed.size(); ++x) {
    const bool differs = std::abs(now[x] - then[x]) > kPixelStep;
    changed[x] = differs ? 255 : 0;
    then[x] = differs ? now[x] : then[x];
  }
}

}  // namespace stof::dsp::ref

#pragma once

#include <cstdint>

#include "dataset/dataset.h"
#include "dsp/base/fixed.h"

namespace stof::host {

// Equal for equal maps, and hardly ever for others: FNV-1a, 64 bits, of the raw disparities.
inline std::uint64_t fingerprint(const dataset::Image<dsp::Disparity>& map) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  const auto take = [&hash](unsigned byte) { hash = (hash ^ byte) * 0x100000001b3U; };
  for (const dsp::Disparity d : map.pixels) {
    const unsigned raw = static_cast<std::uint16_t>(d.raw);
    take(raw & 0xFFU);
    take(raw >> 8U);
  }
  return hash;
}

}  // namespace stof::host

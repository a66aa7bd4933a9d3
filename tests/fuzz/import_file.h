#pragma once

#include <string>

#include "dsp/calib/calibration.h"
#include "host/calibrate/rig/exchange/exchange.h"
#include "tests/fuzz/fuzz_input.h"

// What all targets for files of others have in common.
namespace stof::fuzz {

inline host::NamedText text_of(std::span<const std::byte> input) {
  const auto* const begin = reinterpret_cast<const char*>(input.data());
  return {"input", std::string(begin, begin + input.size())};
}

// Taken as a pair that can be computed with, or refused in one line.
inline void judge(const dataset::Loaded<dsp::RawPair>& rig) {
  if (rig) {
    dsp::Calibration calibration;
    calibration.stereo.raw = *rig;
    require(*dsp::complete(calibration.stereo) == '\0' && *dsp::problem(calibration) == '\0');
    return;
  }
  require(!rig.error().message.empty());
  require(rig.error().message.find('\n') == std::string::npos);
}

}  // namespace stof::fuzz

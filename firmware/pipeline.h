#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/calib/calibration.h"
#include "dsp/depth/depth_maker.h"
#include "firmware/shot.h"
#include "hal/clock.h"

namespace stof::firmware {

// What is decided at start and never again. A PMD lens of 0x0 means stereo alone.
struct Setup {
  dsp::Calibration calibration;
  dsp::DepthParams depth;

  bool has_pmd() const noexcept { return calibration.pmd.lens.width > 0; }
};

inline constexpr std::size_t kSources = 6;  // values of dsp::Source
inline constexpr std::size_t kCauses = 6;   // values of dsp::Cause

struct Stats {
  hal::Duration match{};  // rectification and the search
  hal::Duration convert{};
  hal::Duration fuse{};                           // and the periods of readings
  hal::Duration watch{};                          // comparing the sensors for drift
  std::array<std::uint32_t, kSources> sources{};  // pixels of each
  std::array<std::uint32_t, kCauses> causes{};

  hal::Duration total() const noexcept { return match + convert + fuse + watch; }
};

struct Output {
  dsp::DepthMap map;
  dsp::DriftEstimate drift;  // of the last second
  Stats stats;
};

// One shot to one depth map, by the dsp::DepthMaker that evaluation on the host uses too.
class Pipeline {
 public:
  // Bytes of the Arena; setup.depth.match must pass dsp::check.
  static std::size_t bytes_needed(const Setup& setup) noexcept;

  // Builds all tables. setup.calibration is complete(), problem() of it empty.
  Pipeline(const Setup& setup, hal::Clock& clock, dsp::Arena& arena) noexcept;

  // Frames of the calibration's sizes. The result is valid until the next call.
  const Output& compute(const Shot& shot) noexcept;

 private:
  hal::Clock& clock_;
  dsp::DepthMaker maker_;
  int until_drift_ = 0;  // frames
  Output output_;
};

}  // namespace stof::firmware

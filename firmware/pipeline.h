#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dsp/base/arena.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/fuser.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/matcher.h"
#include "dsp/stereo/rectifier.h"
#include "firmware/shot.h"
#include "hal/clock.h"

namespace stof::firmware {

// What is decided at start and never again. A PMD lens of 0x0 means stereo alone.
struct Setup {
  dsp::Calibration calibration;
  dsp::MatchParams match;
  dsp::FusionParams fusion;

  bool has_pmd() const noexcept { return calibration.pmd.lens.width > 0; }
};

inline constexpr std::size_t kSources = 6;  // values of dsp::Source

struct Stats {
  hal::Duration match{};  // rectification and the search
  hal::Duration convert{};
  hal::Duration fuse{};
  std::array<std::uint32_t, kSources> sources{};  // pixels of each

  hal::Duration total() const noexcept { return match + convert + fuse; }
};

struct Output {
  dsp::DepthMap map;
  Stats stats;
};

// One shot to one depth map, with the parts that evaluation on the host uses too.
class Pipeline {
 public:
  // Bytes of the Arena; setup.match must pass dsp::check.
  static std::size_t bytes_needed(const Setup& setup) noexcept;

  // Builds all tables. setup.calibration is complete(), problem() of it empty.
  Pipeline(const Setup& setup, hal::Clock& clock, dsp::Arena& arena) noexcept;

  // Frames of the calibration's sizes. The result is valid until the next call.
  const Output& compute(const Shot& shot) noexcept;

 private:
  void match(const hal::StereoFrame& frame) noexcept;

  hal::Clock& clock_;
  std::optional<dsp::Rectifier> rectifier_;  // where the calibration asks for one
  dsp::Matcher matcher_;
  std::optional<dsp::Converter> converter_;
  dsp::Fuser fuser_;
  dsp::ImageView<dsp::Disparity> disparity_;
  const dsp::PmdMaps* pmd_ = nullptr;  // of the last PMD frame
  Output output_;
};

}  // namespace stof::firmware

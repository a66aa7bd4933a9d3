#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "dataset/image.h"
#include "dsp/calib/calibration.h"

namespace stof::dataset {

// A PMD recording and the rig it belongs to.
struct PmdRecording {
  // One entry a frame, each four planes A0..A3 stacked from top to bottom (width x 4 height).
  std::vector<Image<std::uint16_t>> frames;
  // As many of calibration.pmd.second, or none.
  std::vector<Image<std::uint16_t>> second_frames;
  std::vector<std::int16_t> fixed_pattern;  // what calibration.pmd.fixed_pattern refers to
  // The camera's constants; `stereo` and `pmd_to_stereo` where the file has a rig.
  dsp::Calibration calibration;
  bool has_rig = false;
  // From the middle of the pair's exposure to that of these samples, microseconds.
  std::int32_t after_pair_us = 0;

  using Samples = std::array<dsp::ImageView<const std::uint16_t>, 4>;
  Samples samples(std::size_t frame) const;
  Samples second_samples(std::size_t frame) const;

  PmdRecording() = default;
  PmdRecording(PmdRecording&&) = default;  // keeps fixed_pattern's storage
  PmdRecording& operator=(PmdRecording&&) = default;
  PmdRecording(const PmdRecording&) = delete;
  PmdRecording& operator=(const PmdRecording&) = delete;
};

// Reads PREFIX.json and PREFIX_raw.pgm. The wiggling table comes from kappa5 - kappa3 where the
// json has none. Truth (range maps, stray light) is never read. The fixed pattern is that of
// `fixed_pattern` where a file is named (then it must be there; 1/8 mm), else PREFIX_fppn.pgm,
// else <W>x<H>_fppn.pgm beside them, else there is none.
Loaded<PmdRecording> read_pmd(const std::filesystem::path& prefix,
                              const std::optional<std::filesystem::path>& fixed_pattern = {});

}  // namespace stof::dataset

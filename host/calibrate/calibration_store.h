#pragma once

#include <filesystem>
#include <vector>

#include "dataset/dataset.h"

// Calibration files (firmware/wire/calibration/calibration_file.h) on the host's disk.
namespace stof::host {

struct StoredCalibration {
  dsp::Calibration calibration;
  std::vector<std::int16_t> fixed_pattern;  // what calibration.pmd.fixed_pattern refers to

  StoredCalibration() = default;
  StoredCalibration(StoredCalibration&&) = default;  // keeps fixed_pattern's storage
  StoredCalibration& operator=(StoredCalibration&&) = default;
  StoredCalibration(const StoredCalibration&) = delete;
  StoredCalibration& operator=(const StoredCalibration&) = delete;
};

// One line where the file cannot be read, is no calibration or a later version's, or holds a number
// that cannot be computed with. A file may lack the stereo pair.
dataset::Loaded<StoredCalibration> read_calibration(const std::filesystem::path& file);
// The same; refused is also a file without a PMD camera.
dataset::Loaded<StoredCalibration> read_pmd_calibration(const std::filesystem::path& file);

std::expected<void, dataset::Problem> write_calibration(const std::filesystem::path& file,
                                                        const dsp::Calibration& calibration);

}  // namespace stof::host

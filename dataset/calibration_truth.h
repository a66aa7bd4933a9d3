#pragma once

#include <array>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/image.h"
#include "dsp/calib/calibration.h"

namespace stof::dataset {

// The board of a set. Its axes: x right, y down, z away from whoever looks at it.
struct BoardTruth {
  std::string kind;  // chess, print, plane
  int columns = 0;   // inner corners of a chessboard, cells of a print, 0 of a plane
  int rows = 0;
  double square_m = 0;
};

// One pose of it, in the middle of the pair's exposure.
struct PoseTruth {
  std::string folder;
  std::string kind;
  dsp::RigidTransform board_to_left;       // into the axes of the left camera as it is
  std::array<double, 3> velocity_m_s{};    // of the middle of the sheet, same axes
  std::array<double, 3> turn_degrees_s{};  // about that middle, same axes
  bool seen_by_left = false;               // the whole pattern
  bool seen_by_right = false;
  bool seen_by_pmd = false;
};

// What an emulated rig really is: for whoever judges a calibration, and for nobody who makes one.
struct CalibrationTruth {
  dsp::Pinhole left;
  dsp::Pinhole right;
  dsp::RigidTransform left_to_right;    // X_right = R X_left + T, cameras as they are
  std::array<double, 9> left_to_rig{};  // X_rig = R X_left: the axes of depths
  std::optional<dsp::Converging> converging = std::nullopt;  // where the pair is not rectified
  std::optional<dsp::Pinhole> pmd = std::nullopt;
  dsp::RigidTransform pmd_to_left{};  // cameras as they are
  double blur_px = 0;                 // of the pair
  double vignetting = 0;
  double pmd_blur_px = 0;
  std::optional<BoardTruth> board = std::nullopt;
  std::vector<PoseTruth> poses{};
};

// Writes it as JSON (README.md); every number reads back equal.
std::expected<void, Problem> write_calibration_truth(const std::filesystem::path& file,
                                                     const CalibrationTruth& truth);

}  // namespace stof::dataset

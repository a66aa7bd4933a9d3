#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/calibration_truth.h"
#include "dsp/calib/calibration.h"

// The emulator's rigs and boards, written as folders that a calibration reads, and what they truly
// are, which it does not.
namespace stof::host::test {

// Flags of stof_emu_pair.
using EmulatorFlags = std::vector<std::string>;

// Writes the folder. One line on stderr and false where the flags are refused.
bool emulate(const std::filesystem::path& folder, const EmulatorFlags& flags);

// What that rig is, and how it is told to somebody who knows all of it but the PMD camera's place:
// that is pmd_to_stereo of the truth.
dataset::CalibrationTruth truth_of(const EmulatorFlags& flags);
dsp::RawPair pair_of(const dataset::CalibrationTruth& truth);
// From the PMD camera's axes to those of the rectified left camera.
dsp::RigidTransform pmd_to_rectified(const dataset::CalibrationTruth& truth);

}  // namespace stof::host::test

#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>

#include "dataset/dataset.h"
#include "hal/emu/imagery/sensors.h"

// Exposures of an emulated rig as recorded ones.
namespace stof::board {

// The pair and its search range.
dataset::StereoScene pictures_of(hal::emu::SensorImagery& imagery, std::uint32_t exposure);

// So many frames of the PMD camera from there on, with the rig's calibration as it is published.
dataset::PmdRecording recording_of(hal::emu::SensorImagery& imagery, std::uint32_t exposure,
                                   std::uint32_t frames);

// The folder, made where it is missing.
std::expected<void, dataset::Problem> make_folder(const std::filesystem::path& folder);

}  // namespace stof::board

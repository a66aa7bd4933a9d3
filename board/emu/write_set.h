#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>

#include "board/emu/scenes.h"
#include "dataset/dataset.h"

// What calibrates an emulated rig, as recorded folders (dataset/README.md: calibration set).
namespace stof::board {

// Of a board, from exposure `first` on: a folder pose_000 for each pose, and the truth of all in
// truth.json. The PMD recordings have `frames` frames, and say nothing of the rig.
std::expected<void, dataset::Problem> write_set(const std::filesystem::path& folder,
                                                const SceneOptions& options, std::uint32_t first,
                                                std::uint32_t frames);

// Of a scene whose pair is raw: what a perfect pair in its place sees, in the folder `ideal`, with
// exact disparities and the true rig; and truth.json.
std::expected<void, dataset::Problem> write_ideal(const std::filesystem::path& folder,
                                                  const SceneOptions& options,
                                                  std::uint32_t exposure, std::uint32_t frames);

}  // namespace stof::board

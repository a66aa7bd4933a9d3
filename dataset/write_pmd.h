#pragma once

#include <expected>
#include <filesystem>

#include "dataset/pmd_recording.h"

namespace stof::dataset {

// Writes PREFIX.json, PREFIX_raw.pgm and, where there is one, PREFIX_fppn.pgm into a folder that
// exists; what is read back is equal. The rig is written where has_rig says so, as the rectified
// pair that it is or becomes. write_pmd leaves a second frequency out, write_pmd_pair needs
// one and writes each under a prefix of its own.
std::expected<void, Problem> write_pmd(const std::filesystem::path& prefix,
                                       const PmdRecording& recording);
std::expected<void, Problem> write_pmd_pair(const std::filesystem::path& prefix,
                                            const std::filesystem::path& other,
                                            const PmdRecording& recording);

}  // namespace stof::dataset

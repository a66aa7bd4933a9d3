#pragma once

#include <expected>
#include <filesystem>

#include "dataset/pmd_recording.h"

namespace stof::dataset {

// Writes PREFIX.json, PREFIX_raw.pgm and, where there is one, PREFIX_fppn.pgm into a folder that
// exists; what is read back is equal. The rig is written where has_rig says so, as the rectified
// pair that it is or becomes. A second frequency is left out.
std::expected<void, Problem> write_pmd(const std::filesystem::path& prefix,
                                       const PmdRecording& recording);

}  // namespace stof::dataset

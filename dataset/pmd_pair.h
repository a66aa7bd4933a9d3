#pragma once

#include <filesystem>
#include <optional>

#include "dataset/pmd_recording.h"

namespace stof::dataset {

// Two recordings of one camera and one scene at two modulation frequencies: one recording with
// calibration.pmd.second. The higher frequency is the first one, in whichever order they are named.
// Where a json has no min_modulation_ratio it is 0.25 here.
Loaded<PmdRecording> read_pmd_pair(const std::filesystem::path& prefix,
                                   const std::filesystem::path& other,
                                   const std::optional<std::filesystem::path>& fixed_pattern = {});

}  // namespace stof::dataset

#pragma once

#include "dsp/depth/depth_maker.h"
#include "firmware/settings/settings.h"
#include "firmware/settings/text/paged_writer.h"

namespace stof::settings {

// The parameters of the pipeline. rig_disparities: holds where the settings say 0. The room of the
// board is checked elsewhere.
dsp::DepthParams depth_params(const Settings& settings, int rig_disparities) noexcept;

// Blocks that an earlier version matched, but this one cannot, because their sums do not fit 16
// bits: prefilter, then block, become as the preset has them; `note` says so (note_fallback()).
void fit_blocks(Settings& settings, PagedWriter& note) noexcept;

// Empty ("") when the matcher's options can be used together, else what cannot and what to do.
const char* problem(const Settings& settings) noexcept;

}  // namespace stof::settings

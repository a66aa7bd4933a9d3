#pragma once

#include "host/calibrate/fit/pmd_fit.h"

namespace stof::host {

// Sign of the phase, offset and, where asked for, stray light of a camera of which nothing is
// known: A ~ exposure / D^2 makes I + jQ linear in both. `phase_falls` is decided where
// `sign_known` is false.
void estimate_initial_model(const WallData& data, bool sign_known, bool stray, PmdModel& model);

}  // namespace stof::host

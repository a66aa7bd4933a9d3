#pragma once

#include <string>

#include "host/evaluate/pmd/figures.h"

namespace stof::host {

// All figures, for programs.
std::string pmd_json(const PmdEvaluation& evaluation);

}  // namespace stof::host

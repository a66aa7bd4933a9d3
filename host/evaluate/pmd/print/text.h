#pragma once

#include <string>

#include "host/evaluate/pmd/figures.h"

namespace stof::host {

// All figures, for people.
std::string pmd_text(const PmdEvaluation& evaluation);

}  // namespace stof::host

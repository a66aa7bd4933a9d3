#pragma once

#include <span>

#include "host/evaluate/fusion/fusion_case.h"
#include "host/report/page/page.h"

namespace stof::host {

// Figures and claims over all cases.
void add_fusion_summary(std::span<const FusionCase> cases, Page& page);

}  // namespace stof::host

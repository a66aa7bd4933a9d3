#pragma once

#include <span>

#include "host/evaluate/fusion/fusion_case.h"
#include "host/report/page/page.h"

namespace stof::host {

// Which figures are worth what their intervals say; what geometry gains, where that was asked for.
void add_fusion_intervals(std::span<const FusionCase> cases, Page& page);
void add_fusion_geometry(std::span<const FusionCase> cases, Page& page);

}  // namespace stof::host

#pragma once

#include <span>

#include "host/evaluate/fusion/fusion_case.h"

// The output of `stof evaluate fusion` on stdout.
namespace stof::host {

void print_fusion_text(const FusionCase& fused, const MatchRequest& match);
void print_fusion_json(const FusionCase& fused, const MatchRequest& match);

// Several: a table with a row for each, and means, of each sensor too where there are several.
void print_fusion_text(std::span<const FusionCase> cases, const MatchRequest& match);
void print_fusion_json(std::span<const FusionCase> cases, const MatchRequest& match);

}  // namespace stof::host

#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "host/evaluate/fusion/fusion_case.h"
#include "host/report/page/page.h"

// What `stof evaluate fusion` found, as one self-contained HTML page: no scripts, no network,
// pictures inside.
namespace stof::host {

// matcher: in words. One line when the file cannot be written.
std::expected<void, dataset::Problem> write_fusion_page(std::span<const FusionCase> cases,
                                                        const std::string& matcher,
                                                        const std::filesystem::path& file);

// Its sections: figures and claims over all cases; which figures are worth what their intervals
// say; what geometry gains, where that was asked for.
void add_fusion_summary(std::span<const FusionCase> cases, Page& page);
void add_fusion_intervals(std::span<const FusionCase> cases, Page& page);
void add_fusion_geometry(std::span<const FusionCase> cases, Page& page);

// "64x16", ... in the order they come.
std::vector<std::string> sensors_of(std::span<const FusionCase> cases);
// As mean_scores(); of all cases where `sensor` is empty.
FusionScores mean_of_sensor(std::span<const FusionCase> cases, const std::string& sensor);

}  // namespace stof::host

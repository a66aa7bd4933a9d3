#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "host/evaluate/fusion/fusion_case.h"
#include "host/report/page/page.h"

// The results of `stof evaluate fusion` as one self-contained HTML page: no scripts, no network,
// pictures inside.
namespace stof::host {

// matcher: in words. One line when the file cannot be written.
std::expected<void, dataset::Problem> write_fusion_page(std::span<const FusionCase> cases,
                                                        const std::string& matcher,
                                                        const std::filesystem::path& file);

}  // namespace stof::host

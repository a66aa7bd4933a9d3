#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "lab/match_params.h"

// The program stof_plain (host/plain): the whole matcher with reference kernels.
namespace stof::host {

struct PlainMatch {
  double ms = 0;          // median of the runs
  std::uint64_t map = 0;  // fingerprint() of its disparities
};

// Whether this is a file that may be executed.
bool can_run(const std::filesystem::path& program);

// Matches the scene in `folder`. Of the params it takes method, cost, block and prefilter, the rest
// being method_defaults(). None: the program failed, and has said why on stderr.
std::optional<PlainMatch> run_plain(const std::filesystem::path& program,
                                    const std::filesystem::path& folder,
                                    const lab::MatchParams& params, int runs);

}  // namespace stof::host

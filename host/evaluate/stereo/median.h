#pragma once

#include <optional>
#include <vector>

namespace stof::host {

// The middle value, or the mean of the middle two; none of nothing.
std::optional<double> median(std::vector<double> values);

// The value below which `share` (0..1) of the values lie: the nearest rank. None of nothing.
std::optional<double> percentile(std::vector<double> values, double share);

}  // namespace stof::host

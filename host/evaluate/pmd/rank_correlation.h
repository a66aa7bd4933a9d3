#pragma once

#include <vector>

namespace stof::host {

// Spearman's rank correlation; equal values share their mean rank. NaN from fewer than two pairs,
// or where all values of one side are equal.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace stof::host

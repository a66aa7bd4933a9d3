#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

namespace stof::host {

// The mean of a figure, a member or a function of a score, over the scores that have it.
template <typename Score, typename Figure>
std::optional<double> mean_of(std::span<const Score> scores, Figure figure) {
  double sum = 0;
  std::size_t count = 0;
  for (const Score& score : scores) {
    if (const std::optional<double> value = std::invoke(figure, score)) {
      sum += *value;
      ++count;
    }
  }
  return count == 0 ? std::nullopt : std::optional(sum / static_cast<double>(count));
}

}  // namespace stof::host

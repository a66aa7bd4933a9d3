#include "dsp/fusion/resolve/fattened_edge.h"

#include <algorithm>
#include <cstdlib>

namespace stof::dsp {
namespace {

constexpr std::size_t kMean = 3;  // px

int sum(std::span<const std::uint8_t> pixels) noexcept {
  int all = 0;
  for (const std::uint8_t pixel : pixels) {
    all += pixel;
  }
  return all;
}

}  // namespace

FattenedEdge::FattenedEdge(std::span<const std::uint8_t> picture, std::size_t left_at,
                           std::size_t right_at) noexcept
    : picture_(picture), end_(right_at) {
  if (left_at + 1 < kMean || right_at + kEdgeBand + kMean > picture.size()) {
    return;
  }
  int greatest = kEdgeStep - 1;
  for (std::size_t x = right_at; x <= right_at + kEdgeBand; ++x) {
    const int step = std::abs(picture[x] - picture[x - 1]);
    end_ = step > greatest ? x : end_;
    greatest = std::max(greatest, step);
  }
  behind_ = sum(picture.subspan(left_at + 1 - kMean, kMean));
  near_ = sum(picture.subspan(end_, kMean));
}

bool FattenedEdge::is_behind(std::size_t x) const noexcept {
  const int here = static_cast<int>(kMean) * picture_[x];
  return 5 * std::abs(here - behind_) < 2 * std::abs(here - near_);
}

}  // namespace stof::dsp

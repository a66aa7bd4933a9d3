#include "dsp/fusion/unwrap/decision/wrap_regions.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

constexpr std::int16_t kTwisted = 32767;
constexpr int kMostGain = 15;  // 16 wraps at most

}  // namespace

WrapRegions::WrapRegions(std::size_t pixels, Arena& arena) noexcept
    : parent_(arena.take_passing<std::int32_t>(pixels)),
      gain_(arena.take_passing<std::int16_t>(pixels)),
      base_(arena.take_passing<std::int16_t>(pixels)),
      size_(arena.take_passing<std::int32_t>(pixels)),
      proofs_(arena.take_passing<std::int32_t>(pixels)),
      against_(arena.take_passing<std::int32_t>(pixels)) {}

void WrapRegions::clear() noexcept {
  for (std::size_t i = 0; i < parent_.size(); ++i) {
    parent_[i] = static_cast<std::int32_t>(i);
  }
  std::ranges::fill(gain_, std::int16_t{0});
  std::ranges::fill(base_, std::int16_t{0});
  std::ranges::fill(size_, 1);
  std::ranges::fill(proofs_, 0);
  std::ranges::fill(against_, 0);
}

WrapRegions::Place WrapRegions::find(std::size_t pixel) noexcept {
  std::size_t root = pixel;
  int gain = 0;
  while (index(parent_[root]) != root) {
    gain += gain_[root];
    root = index(parent_[root]);
  }
  int left = gain;
  while (pixel != root) {
    const std::size_t next = index(parent_[pixel]);
    const int step = gain_[pixel];
    parent_[pixel] = static_cast<std::int32_t>(root);
    gain_[pixel] = static_cast<std::int16_t>(left);
    left -= step;
    pixel = next;
  }
  return {root, gain};
}

void WrapRegions::unite(std::size_t a, std::size_t b, int gain) noexcept {
  Place from = find(a);
  Place to = find(b);
  int between = from.gain + gain - to.gain;  // wraps(root of b) - wraps(root of a)
  if (from.root == to.root) {
    base_[from.root] = between == 0 ? base_[from.root] : kTwisted;
    return;
  }
  if (size_[from.root] < size_[to.root]) {
    std::swap(from, to);
    between = -between;
  }
  const bool twisted =
      base_[from.root] == kTwisted || base_[to.root] == kTwisted || std::abs(between) > kMostGain;
  base_[from.root] = twisted ? kTwisted : base_[from.root];
  parent_[to.root] = static_cast<std::int32_t>(from.root);
  gain_[to.root] = static_cast<std::int16_t>(std::clamp(between, -kMostGain, kMostGain));
  size_[from.root] += size_[to.root];
}

void WrapRegions::prove(std::size_t pixel) noexcept {
  const Place place = find(pixel);
  const std::size_t root = place.root;
  if (base_[root] == kTwisted) {
    return;
  }
  if (proofs_[root] == 0) {
    base_[root] = static_cast<std::int16_t>(-place.gain);
  }
  ++(base_[root] == -place.gain ? proofs_ : against_)[root];
}

void WrapRegions::contradict(std::size_t pixel, int wraps) noexcept {
  const Place place = find(pixel);
  against_[place.root] += base_[place.root] == wraps - place.gain ? 0 : 1;
}

int WrapRegions::wraps(std::size_t pixel) noexcept {
  const Place place = find(pixel);
  const std::size_t root = place.root;
  if (base_[root] == kTwisted || proofs_[root] < kLeast ||
      against_[root] * kRobust > proofs_[root]) {
    return kUndecided;
  }
  return base_[root] + place.gain;
}

}  // namespace stof::dsp

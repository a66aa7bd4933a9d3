#include "dsp/fusion/drift/disparity_shift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

// Where a number comes from stands beside it. What is derived says from what. What is chosen has
// the range over which it was varied on the rendered corridor of drift_corridor_test (48 frames of
// 640x480 with noise; the PMD camera turned by 0, 0.2 and 0.5 degrees): within it no turn that is
// found moves by more than 0.015 degrees, which is its own standard deviation.

// Histogram of disparity errors, 1/16 px: +-8 px, what a turn of a degree does at a focal length of
// 460 px. What is further off is another rig, not drift.
constexpr int kBins = 256;
constexpr int kMiddle = kBins / 2;
// Disparities this close to the median are of the plane, 1/16 px: a match of whole pixels is off by
// half of one, the slant within its block adds as much (chosen: 8 to 32).
constexpr int kKept = Disparity::kOne;
// Shares: of the pixels that have a disparity; of these that are kept; of the plane that lies
// inside the picture (chosen: 0.25 to 0.75; 0.6 to 0.95; 0.4 to 0.95).
constexpr double kLeastSeen = 0.5;
constexpr double kLeastAgree = 0.8;
constexpr double kLeastInside = 0.7;

// Blocks a side: 16 blocks tell a standard deviation to a fifth, and one of a patch of 24 px has 36
// pixels; of fewer than 2x2 pixels a block has no derivative of its own.
constexpr int kBlocks = 4;
constexpr int kLeastSide = 2 * kBlocks;
// Share of the pixels that have a partner in the right picture (chosen: 0.3 to 0.9).
constexpr double kLeastPixels = 0.6;
// Contrast of the left picture over that of the right one: what has less is something else (chosen:
// 0.1 to 0.6).
constexpr double kLeastGain = 0.3;
// A fit this far from the disparity map, px, has found another texture: half a pixel is a whole
// match's own error (chosen: 0.35 to 1.4).
constexpr double kFarthestPx = 0.7;
// Of white noise the filters leave a variance of 0.125 in the derivative and of 0.737 in the
// difference of both pictures, mean over all places between pixels: 0.17 of it, rounded up.
constexpr double kNoiseShare = 0.18;
// Squared derivative above noise, in variances of the difference (chosen: 0.1 to 0.4; at 1.2 a
// third of the corridor's patches is lost, and yaw is found 0.05 degrees too small).
constexpr double kLeastSignal = 0.4;
// The filters make the noise of neighbours alike: 1.23 for the noise and the texture of white
// pictures by their autocorrelations (chosen: 1.0 to 1.4; less than 1.23 drops more patches).
constexpr double kNeighbours = 1.1;
// The standard deviation that blocks show, with 14 degrees of freedom, scatters by a fifth of
// itself: three of these, and what kNeighbours is too small by.
constexpr double kDisagreement = 1.7;
// What noise does not explain, px: twice the hundredth that interpolation is off by (chosen: 0 to
// 0.1).
constexpr double kDisagreementPx = 0.02;
// A fit's own error, px, in every patch: interpolation, what is not quite flat (chosen: 0.01 to
// 0.1).
constexpr double kFitNoisePx = 0.03;

struct Box {
  int x_begin = 0;
  int x_end = 0;
  int y_begin = 0;
  int y_end = 0;
};

std::optional<Box> inside(const ExpectedPlane& plane, int width, int height) noexcept {
  const double x_low = std::ceil(std::max(plane.u_low, 1.0));
  const double y_low = std::ceil(std::max(plane.v_low, 0.0));
  const double x_high = std::floor(std::min(plane.u_high, width - 2.0));
  const double y_high = std::floor(std::min(plane.v_high, height - 1.0));
  const double area = (x_high - x_low + 1) * (y_high - y_low + 1);
  const double whole = (plane.u_high - plane.u_low) * (plane.v_high - plane.v_low);
  if (!(x_high - x_low + 1 >= kLeastSide) || !(y_high - y_low + 1 >= kLeastSide) ||
      !(area >= kLeastInside * whole)) {
    return std::nullopt;
  }
  return Box{.x_begin = static_cast<int>(x_low),
             .x_end = static_cast<int>(x_high) + 1,
             .y_begin = static_cast<int>(y_low),
             .y_end = static_cast<int>(y_high) + 1};
}

double expected(const ExpectedPlane& plane, int x, int y) noexcept {
  return plane.d + plane.gx * (x - plane.u) + plane.gy * (y - plane.v);
}

// Median of measured less expected disparity, or nothing.
std::optional<double> rough_shift(const ExpectedPlane& plane, const Box& box,
                                  ImageView<const Disparity> disparity) noexcept {
  std::array<int, kBins> bins{};
  int seen = 0;
  for (int y = box.y_begin; y < box.y_end; ++y) {
    const std::span<const Disparity> row = disparity.row(y);
    for (int x = box.x_begin; x < box.x_end; ++x) {
      const Disparity d = row[index(x)];
      if (!d.valid()) {
        continue;
      }
      ++seen;
      const double bin = d.raw - Disparity::kOne * expected(plane, x, y) + kMiddle + 0.5;
      if (bin >= 0 && bin < kBins) {
        ++bins[static_cast<std::size_t>(bin)];
      }
    }
  }
  if (seen < kLeastSeen * (box.x_end - box.x_begin) * (box.y_end - box.y_begin)) {
    return std::nullopt;
  }
  int median = 0;
  for (int below = 0; median < kBins - 1; ++median) {
    below += bins[index(median)];
    if (2 * below >= seen) {
      break;
    }
  }
  int kept = 0;
  double sum = 0;
  for (int i = std::max(median - kKept, 0); i <= std::min(median + kKept, kBins - 1); ++i) {
    kept += bins[index(i)];
    sum += 1.0 * bins[index(i)] * (i - kMiddle);
  }
  if (kept < kLeastAgree * seen || kept == 0) {
    return std::nullopt;
  }
  return sum / kept / Disparity::kOne;
}

// Sums of a block over grey values right and left, and the right one's derivative.
struct Moments {
  double n = 0;
  double r = 0;
  double g = 0;
  double l = 0;
  double rr = 0;
  double rg = 0;
  double gg = 0;
  double rl = 0;
  double gl = 0;
  double ll = 0;

  void add(double right, double slope, double left) noexcept {
    n += 1;
    r += right;
    g += slope;
    l += left;
    rr += right * right;
    rg += right * slope;
    gg += slope * slope;
    rl += right * left;
    gl += slope * left;
    ll += left * left;
  }
  void centre() noexcept {
    rr -= r * r / n;
    rg -= r * g / n;
    gg -= g * g / n;
    rl -= r * l / n;
    gl -= g * l / n;
    ll -= l * l / n;
  }
  // What is not centred is no longer of interest.
  void add(const Moments& other, double weight) noexcept {
    n += weight * other.n;
    rr += weight * other.rr;
    rg += weight * other.rg;
    gg += weight * other.gg;
    rl += weight * other.rl;
    gl += weight * other.gl;
    ll += weight * other.ll;
  }
};

// 1 2 1 around row[i], four times the grey value.
int soft(std::span<const std::uint8_t> row, std::size_t i) noexcept {
  return row[i - 1] + 2 * row[i] + row[i + 1];
}

Moments gather(const ExpectedPlane& plane, const MatchedPair& pair, const Box& box,
               double shift) noexcept {
  Moments out;
  const double last = pair.right.width() - 4;
  for (int y = box.y_begin; y < box.y_end; ++y) {
    const std::span<const std::uint8_t> left = pair.left.row(y);
    const std::span<const std::uint8_t> right = pair.right.row(y);
    for (int x = box.x_begin; x < box.x_end; ++x) {
      const double at = x - expected(plane, x, y) - shift;
      if (!(at >= 2) || !(at < last)) {
        continue;
      }
      const std::size_t i = static_cast<std::size_t>(at);
      const double part = at - static_cast<double>(i);
      const int before = soft(right, i - 1);
      const int here = soft(right, i);
      const int next = soft(right, i + 1);
      const int after = soft(right, i + 2);
      // The cubic through all four: a straight line is off by a hundredth of a pixel.
      const double bend = (before - after) / 6.0 + (next - here) / 2.0;
      const double value = here + part * (next - here) +
                           part * (1 - part) * (bend * (1 + part) - (before + next) / 2.0 + here);
      const double slope = ((1 - part) * (next - before) + part * (after - here)) / 2;
      out.add(value / 4 - 128, slope / 4, soft(left, index(x)) / 4.0 - 128);
    }
  }
  return out;
}

struct Fit {
  double px = 0;
  double variance = 0;
  bool sound = false;  // texture above noise, one plane
};

constexpr std::size_t kAll = std::size_t{kBlocks} * kBlocks;
using Blocks = std::array<Moments, kAll>;

// The moments of all blocks, centred, none with more than the median block's texture. Nothing where
// too few pixels have a partner.
std::optional<Blocks> weigh_blocks(const ExpectedPlane& plane, const MatchedPair& pair,
                                   const Box& box, double start) noexcept {
  const int width = box.x_end - box.x_begin;
  const int height = box.y_end - box.y_begin;
  Blocks out;
  std::array<double, kAll> texture{};
  double pixels = 0;
  for (std::size_t k = 0; k < kAll; ++k) {
    const int column = static_cast<int>(k) % kBlocks;
    const int row = static_cast<int>(k) / kBlocks;
    Moments block = gather(plane, pair,
                           {.x_begin = box.x_begin + width * column / kBlocks,
                            .x_end = box.x_begin + width * (column + 1) / kBlocks,
                            .y_begin = box.y_begin + height * row / kBlocks,
                            .y_end = box.y_begin + height * (row + 1) / kBlocks},
                           start);
    if (block.n > 1) {
      pixels += block.n;
      block.centre();
      texture[k] = block.gg / block.n;
      out[k] = block;
    }
  }
  if (pixels < kLeastPixels * width * height) {
    return std::nullopt;
  }
  std::array<double, kAll> sorted = texture;
  std::ranges::nth_element(sorted, sorted.begin() + kAll / 2);
  const double most = sorted[kAll / 2];
  for (std::size_t k = 0; k < kAll; ++k) {
    Moments weighted;
    weighted.add(out[k], texture[k] > most ? most / texture[k] : 1);
    out[k] = weighted;
  }
  return out;
}

std::optional<Fit> fit(const ExpectedPlane& plane, const MatchedPair& pair, const Box& box,
                       double start) noexcept {
  const std::optional<Blocks> blocks = weigh_blocks(plane, pair, box, start);
  if (!blocks) {
    return std::nullopt;
  }
  Moments all;
  for (const Moments& block : *blocks) {
    all.add(block, 1);
  }
  const double along = all.rr > 0 ? all.rg / all.rr : 0;
  const double information = all.gg - along * all.rg;
  if (!(all.rr > 0) || !(information > 0)) {
    return std::nullopt;
  }
  const double moved = (all.gl - along * all.rl) / information;  // - gain e
  const double gain = (all.rl - all.rg * moved) / all.rr;
  const double rest = std::max(all.ll - gain * all.rl - moved * all.gl, 0.0);
  const double signal = information - kNoiseShare * rest;
  if (!(gain > kLeastGain) || !(signal > kLeastSignal * rest)) {
    return std::nullopt;
  }
  double disagreement = 0;
  for (const Moments& b : *blocks) {
    const double score =
        b.gl - gain * b.rg - moved * b.gg - along * (b.rl - gain * b.rr - moved * b.rg);
    disagreement += score * score;
  }
  const double scale = 1 / (signal * gain);
  const double sigma = std::sqrt(disagreement * kAll / (kAll - 2)) * scale;
  const double noise = kNeighbours * std::sqrt(rest / all.n * information) * scale;
  return Fit{.px = start - moved * information * scale,
             .variance = sigma * sigma,
             .sound = sigma <= kDisagreement * noise + kDisagreementPx};
}

}  // namespace

std::optional<DisparityShift> disparity_shift(const ExpectedPlane& plane,
                                              const MatchedPair& pair) noexcept {
  const std::optional<Box> box = inside(plane, pair.disparity.width(), pair.disparity.height());
  if (!box) {
    return std::nullopt;
  }
  const std::optional<double> rough = rough_shift(plane, *box, pair.disparity);
  if (!rough) {
    return std::nullopt;
  }
  const std::optional<Fit> first = fit(plane, pair, *box, *rough);
  if (!first || !(std::abs(first->px - *rough) <= kFarthestPx)) {
    return std::nullopt;
  }
  const std::optional<Fit> second = fit(plane, pair, *box, first->px);
  if (!second || !second->sound || !(std::abs(second->px - *rough) <= kFarthestPx)) {
    return std::nullopt;
  }
  return DisparityShift{.px = second->px, .variance = second->variance + kFitNoisePx * kFitNoisePx};
}

}  // namespace stof::dsp

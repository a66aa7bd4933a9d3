#include "dsp/fusion/guide/guide_maker.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/fusion/guide/guide_tables.h"
#include "dsp/fusion/project/splat.h"

namespace stof::dsp {
namespace {

constexpr std::size_t kMostSteps = 64;
constexpr std::uint32_t kOneQ8 = 256;
constexpr std::uint32_t kOneQ16 = 65536;
constexpr int kMostReach = 32;
constexpr std::uint8_t kUnguided = 1;  // the only flag that readings have here
constexpr QuarterMm kNoGuide = 0;      // as a low end: the smallest, so that it spreads
// Ends that differ by more than an eighth within `reach` are a step in depth: whatever is larger
// than a slope, and no smaller than what neighbouring readings differ by.
constexpr std::uint32_t kStepShare = 8;
constexpr Candidates kNoCandidate{.first = 1, .last = 0};
constexpr int kLastCandidate = kBeyondCandidates - 1;

std::uint32_t fixed(double value, std::uint32_t one) noexcept {
  return static_cast<std::uint32_t>(std::lround(value * one));
}

QuarterMm saturated(std::uint32_t depth) noexcept {
  return static_cast<QuarterMm>(std::min<std::uint32_t>(depth, kMaxQuarterMm));
}

// At least 1.
QuarterMm saturated_difference(std::uint32_t depth, std::uint32_t less) noexcept {
  return static_cast<QuarterMm>(depth > less + 1 ? depth - less : 1);
}

// Whether a thing larger than a pixel may be where this reading is missing: where most of its
// neighbours have one, and of one surface each, they speak for it.
bool may_hide(const PmdMaps& maps, int x, int y) noexcept {
  constexpr int kMostNeighbours = 5;
  const int width = maps.distance.width();
  const int height = maps.distance.height();
  int known = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
      const bool reads = maps.distance.at(u, v) != kNoDepth;
      known += reads && (maps.flags.at(u, v) & kPmdEdge) == 0 ? 1 : 0;
    }
  }
  return known < kMostNeighbours;
}

}  // namespace

PmdMaps GuideMaker::Readings::maps() const noexcept {
  PmdMaps maps;
  maps.distance = distance;
  maps.low = low;
  maps.high = high;
  maps.flags = flags;
  return maps;
}

bool GuideMaker::serves(const Calibration& calibration) noexcept {
  return !calibration.stereo.converging && calibration.pmd.lens.width > 0 &&
         calibration.pmd.lens.height > 0;
}

GuideMaker::GuideMaker(const Calibration& calibration, const GuideParams& params, int min_disparity,
                       int disparities, int width, int height, Arena& arena) noexcept
    : reach_(params.reach),
      sigmas_q8_(fixed(params.sigmas, kOneQ8)),
      most_sigma_q16_(fixed(params.most_sigma, kOneQ16)),
      farthest_(fixed(params.farthest_m, kQuarterMmPerMetre)),
      reprojector_(calibration, width, height, arena) {
  STOF_CHECK(serves(calibration) && params.reach >= 0 && params.reach <= kMostReach);
  STOF_CHECK(params.margin >= 0 && params.margin < 1 && params.sigmas <= 256 &&
             params.most_sigma >= 0 && params.most_sigma <= 1 && params.farthest_m >= 0 &&
             params.farthest_m <= 100'000);
  const Pinhole& lens = calibration.pmd.lens;
  readings_.distance = arena.take_passing_image<QuarterMm>(lens.width, lens.height);
  readings_.low = arena.take_passing_image<QuarterMm>(lens.width, lens.height);
  readings_.high = arena.take_passing_image<QuarterMm>(lens.width, lens.height);
  readings_.flags = arena.take_passing_image<std::uint8_t>(lens.width, lens.height);
  view_.nearest = arena.take_passing_image<QuarterMm>(width, height);
  view_.low = arena.take_passing_image<QuarterMm>(width, height);
  view_.high = arena.take_passing_image<QuarterMm>(width, height);
  view_.flags = arena.take_passing_image<std::uint8_t>(width, height);
  spread_high_ = arena.take_passing_image<QuarterMm>(width, height);
  guide_ = arena.take_image<Candidates>(width, height);
  row_low_ = arena.take_passing<QuarterMm>(index(width + 2 * reach_));
  row_high_ = arena.take_passing<QuarterMm>(index(width + 2 * reach_));
  first_of_ = arena.take<std::int16_t>(kGuideDepths);
  last_of_ = arena.take<std::int16_t>(kGuideDepths);
  steps_ = arena.take<QuarterMm>(kMostSteps);
  if (!arena.is_measuring()) {
    fill_guide_candidates(calibration.stereo, min_disparity, params.margin, first_of_, last_of_);
    steps_ = steps_.first(fill_guide_distances(calibration, min_disparity, disparities, steps_));
  }
}

void GuideMaker::judge_row(const PmdMaps& maps, int y) const noexcept {
  const std::span<const QuarterMm> sigma = maps.sigma.row(y);
  const std::span<const QuarterMm> low = maps.low.row(y);
  const std::span<const QuarterMm> high = maps.high.row(y);
  const std::span<const std::uint8_t> flags = maps.flags.row(y);
  const std::span<QuarterMm> distance = readings_.distance.row(y);
  const std::span<QuarterMm> near = readings_.low.row(y);
  const std::span<QuarterMm> far = readings_.high.row(y);
  const std::span<std::uint8_t> unguided = readings_.flags.row(y);
  std::ranges::copy(maps.distance.row(y), distance.begin());
  for (std::size_t x = 0; x < distance.size(); ++x) {
    const std::uint32_t reach = (std::uint32_t{sigma[x]} * sigmas_q8_ + kOneQ8 - 1) / kOneQ8;
    near[x] = std::min(low[x], saturated_difference(distance[x], reach));
    const bool doubtful =
        farthest_ != 0 && maps.range != 0 && std::uint64_t{near[x]} + maps.range <= farthest_;
    far[x] = doubtful ? kMaxQuarterMm : std::max(high[x], saturated(distance[x] + reach));
    const bool noisy =
        std::uint64_t{sigma[x]} * kOneQ16 > std::uint64_t{most_sigma_q16_} * distance[x];
    const bool unsure = (flags[x] & (kPmdEdge | kPmdOutOfRange)) != 0;
    unguided[x] = noisy || unsure ? kUnguided : std::uint8_t{0};
  }
}

// Leaves in readings_.flags which readings may hide something; false where none may.
bool GuideMaker::find_hidden(const PmdMaps& maps) const noexcept {
  bool any = false;
  for (int y = 0; y < maps.distance.height(); ++y) {
    for (int x = 0; x < maps.distance.width(); ++x) {
      const bool hides = maps.distance.at(x, y) == kNoDepth && may_hide(maps, x, y);
      readings_.flags.at(x, y) = hides ? kUnguided : std::uint8_t{0};
      any = any || hides;
    }
  }
  return any;
}

// A missing reading may be of anything along its ray: pixels of the left view where that would hide
// what is splatted there become unguided.
void GuideMaker::open_before_missing() noexcept {
  for (const QuarterMm step : steps_) {
    for (int y = 0; y < readings_.flags.height(); ++y) {
      const auto at_step = [&](std::uint8_t flag) noexcept { return flag != 0 ? step : kNoDepth; };
      std::ranges::transform(readings_.flags.row(y), readings_.distance.row(y).begin(), at_step);
      std::ranges::copy(readings_.distance.row(y), readings_.low.row(y).begin());
      std::ranges::copy(readings_.distance.row(y), readings_.high.row(y).begin());
    }
    reprojector_.locate(readings_.maps());
    for (const Footprint& f : reprojector_.footprints()) {
      const FootprintValue unguided{f.value.visible, kNoSplat, 0, kUnguided};
      const std::size_t first = index(f.x_begin);
      const std::size_t count = index(f.x_end - f.x_begin);
      for (int y = f.y_begin; y < f.y_end; ++y) {
        best::splat_interval(unguided, view_.nearest.row(y).subspan(first, count),
                             view_.low.row(y).subspan(first, count),
                             view_.high.row(y).subspan(first, count),
                             view_.flags.row(y).subspan(first, count));
      }
    }
  }
}

// Extremes within reach_ columns.
void GuideMaker::spread_along_row(int y) noexcept {
  const std::span<QuarterMm> low = view_.low.row(y);
  const std::span<const QuarterMm> high = view_.high.row(y);
  const std::span<const std::uint8_t> flags = view_.flags.row(y);
  const std::size_t n = low.size();
  const std::size_t reach = index(reach_);
  std::ranges::fill(row_low_, kMaxQuarterMm);
  std::ranges::fill(row_high_, QuarterMm{0});
  for (std::size_t x = 0; x < n; ++x) {
    const bool unguided = flags[x] != 0 || high[x] == 0;  // or nothing splatted
    low[x] = unguided ? kNoGuide : low[x];
    row_low_[x + reach] = low[x];
    row_high_[x + reach] = high[x];
  }
  const std::span<QuarterMm> lowest = view_.nearest.row(y);
  const std::span<QuarterMm> highest = spread_high_.row(y);
  std::ranges::copy(row_low_.first(n), lowest.begin());
  std::ranges::copy(row_high_.first(n), highest.begin());
  for (std::size_t k = 1; k <= 2 * reach; ++k) {
    const QuarterMm* const lows = row_low_.data() + k;
    const QuarterMm* const highs = row_high_.data() + k;
    for (std::size_t x = 0; x < n; ++x) {
      lowest[x] = std::min(lowest[x], lows[x]);
      highest[x] = std::max(highest[x], highs[x]);
    }
  }
}

void GuideMaker::write_row(int y) noexcept {
  const std::span<const QuarterMm> own_low = view_.low.row(y);
  const std::span<const QuarterMm> own_high = view_.high.row(y);
  const std::size_t n = own_low.size();
  const std::span<QuarterMm> low = row_low_.first(n);
  const std::span<QuarterMm> high = row_high_.first(n);
  std::ranges::copy(view_.nearest.row(y), low.begin());
  std::ranges::copy(spread_high_.row(y), high.begin());
  const int end = std::min(y + reach_ + 1, view_.low.height());
  for (int near = std::max(y - reach_, 0); near < end; ++near) {
    const QuarterMm* const lows = view_.nearest.row(near).data();
    const QuarterMm* const highs = spread_high_.row(near).data();
    for (std::size_t x = 0; x < n; ++x) {
      low[x] = std::min(low[x], lows[x]);
      high[x] = std::max(high[x], highs[x]);
    }
  }
  const std::span<Candidates> out = guide_.row(y);
  for (std::size_t x = 0; x < n; ++x) {
    const bool step = std::uint32_t{low[x]} * kStepShare < own_low[x] * (kStepShare - 1) ||
                      std::uint32_t{own_high[x]} * (kStepShare + 1) < high[x] * kStepShare;
    out[x] = {};
    if (low[x] == kNoGuide || step) {
      continue;
    }
    const int first = first_of_[index(high[x] / kGuideDepthStep)];
    const int last = last_of_[index(low[x] / kGuideDepthStep)];
    if (first == kBeyondCandidates || last == kBeforeCandidates) {
      out[x] = kNoCandidate;
    } else {
      out[x] = {.first = static_cast<std::uint8_t>(std::max(first, 0)),
                .last = static_cast<std::uint8_t>(std::min(last, kLastCandidate))};
    }
  }
}

Guide GuideMaker::make(const PmdMaps& maps) noexcept {
  STOF_CHECK(same_size(maps.distance, readings_.distance) && same_size(maps.sigma, maps.distance) &&
             same_size(maps.low, maps.distance) && same_size(maps.high, maps.distance) &&
             same_size(maps.flags, maps.distance));
  for (int y = 0; y < maps.distance.height(); ++y) {
    judge_row(maps, y);
  }
  reprojector_.locate(readings_.maps());
  reprojector_.splat(view_.low.rows(), view_);
  if (find_hidden(maps)) {
    open_before_missing();
  }
  for (int y = 0; y < view_.low.height(); ++y) {
    spread_along_row(y);
  }
  for (int y = 0; y < view_.low.height(); ++y) {
    write_row(y);
  }
  return guide_;
}

}  // namespace stof::dsp

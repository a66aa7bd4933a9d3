#include "dsp/fusion/unwrap/evidence/wrap_evidence.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/index.h"
#include "dsp/fusion/project/projection.h"

namespace stof::dsp {
namespace {

// Pixels of the left view that a PMD pixel covers, about.
double footprint_of(const Calibration& calibration) noexcept {
  const Pinhole& left = calibration.stereo.left;
  const Pinhole& pmd = calibration.pmd.lens;
  return std::max(left.fx / pmd.fx, left.fy / pmd.fy);
}

}  // namespace

WrapEvidence::WrapEvidence(const Calibration& calibration, const FusionParams& params,
                           int min_disparity, int disparities, int width, int height,
                           Arena& arena) noexcept
    : max_range_(params.max_range),
      samples_(calibration.stereo, params.stereo_sigma, min_disparity, disparities, width, height,
               footprint_of(calibration), arena),
      projection_(projection_of(calibration)),
      rays_(make_ray_table(calibration, arena)) {
  const std::size_t row = index(calibration.pmd.lens.width);
  support_ = {arena.take_passing<std::int16_t>(row), arena.take_passing<std::uint16_t>(row)};
  candidates_ = {arena.take_passing<QuarterMm>(row),    arena.take_passing<std::int32_t>(row),
                 arena.take_passing<std::int32_t>(row), arena.take_passing<QuarterMm>(row),
                 arena.take_passing<QuarterMm>(row),    arena.take_passing<Votes>(row)};
}

void WrapEvidence::read_row(const PmdMaps& pmd, int y, const AmplitudeBound& bound,
                            WrapMaps& maps) noexcept {
  const std::span<const QuarterMm> distance = pmd.distance.row(y);
  const std::span<const QuarterMm> sigma = pmd.sigma.row(y);
  const std::span<const std::uint16_t> amp2 = pmd.amp2.row(y);
  const std::size_t first = maps.place(0, y);
  for (std::size_t x = 0; x < distance.size(); ++x) {
    const std::size_t i = first + x;
    maps.readings[i] = {distance[x], sigma[x], bound.amp2(amp2[x])};
    maps.bright[i] =
        distance[x] != kNoDepth && bound.excludes(maps.readings[i], maps.distance(i, 1));
  }
}

// The distances of a row's readings if they wrapped k times, where their amplitude allows that.
void WrapEvidence::place_row(const PmdMaps& pmd, int y, int k, const AmplitudeBound& bound,
                             const WrapMaps& maps) const noexcept {
  const std::span<const QuarterMm> distance = pmd.distance.row(y);
  const std::size_t first = maps.place(0, y);
  const std::uint32_t more = static_cast<std::uint32_t>(k) * maps.range;
  const QuarterMm turns = static_cast<QuarterMm>(more);
  const QuarterMm room = static_cast<QuarterMm>(kMaxQuarterMm - more);
  const std::span<QuarterMm> out = candidates_.distance;
  for (std::size_t x = 0; x < distance.size(); ++x) {
    // No depth, less one, is beyond any room.
    const bool fits = static_cast<QuarterMm>(distance[x] - 1) < room && !maps.bright[first + x];
    const QuarterMm there = static_cast<QuarterMm>(distance[x] + turns);
    out[x] = fits ? there : kNoDepth;
  }
  for (std::size_t x = 0; k > 1 && x < distance.size(); ++x) {
    if (out[x] != kNoDepth && bound.excludes(maps.readings[first + x], out[x])) {
      out[x] = kNoDepth;
    }
  }
}

// The next columns behind `end` with such a distance, as whole blocks.
WrapEvidence::Columns WrapEvidence::next_columns(std::size_t end) const noexcept {
  constexpr std::size_t kBlock = 16;
  const std::span<const QuarterMm> distance = candidates_.distance;
  const auto is_empty = [&](std::size_t x) noexcept {
    const auto block = distance.subspan(x, std::min(kBlock, distance.size() - x));
    QuarterMm any = 0;
    for (const QuarterMm there : block) {
      any = static_cast<QuarterMm>(any | there);
    }
    return any == kNoDepth;
  };
  std::size_t begin = end;
  while (begin < distance.size() && is_empty(begin)) {
    begin += kBlock;
  }
  end = begin;
  while (end < distance.size() && !is_empty(end)) {
    end += kBlock;
  }
  return {std::min(begin, distance.size()), std::min(end, distance.size())};
}

// Where they lie in the left view, and what stereo says there.
void WrapEvidence::look_up(std::span<const QuarterMm> distance, const PmdMaps& pmd, int y,
                           std::size_t begin) noexcept {
  const std::size_t n = distance.size();
  const Candidates c = candidates_.first(n);
  const RayRow rays = ray_row(rays_, pmd.distance.width(), y);
  best::project({rays.x.subspan(begin, n), rays.y.subspan(begin, n), rays.z.subspan(begin, n)},
                distance, projection_, c.u, c.v, c.depth);
  const std::span<const QuarterMm> sigma = pmd.sigma.row(y).subspan(begin, n);
  for (std::size_t x = 0; x < sigma.size(); ++x) {
    // Two sigma, and what the calibration of both cameras may be off by.
    const int tolerance = 2 * sigma[x] + c.depth[x] / 64;
    c.tolerance[x] = static_cast<QuarterMm>(std::min<int>(tolerance, kMaxQuarterMm));
  }
  best::count_votes({c.u, c.v, c.depth, c.tolerance}, samples_.grid(), pmd.widest, c.votes);
}

// Without branches and in 16 bits, so that compilers make vectors of it.
void WrapEvidence::judge(int y, int k, const Columns& columns, WrapMaps& maps) const noexcept {
  const std::size_t first = maps.place(0, y) + columns.begin;
  const std::size_t n = columns.end - columns.begin;
  const std::span<std::uint16_t> possible = maps.possible.subspan(first, n);
  const std::span<std::uint16_t> mixed = maps.mixed.subspan(first, n);
  const std::span<const Votes> votes = candidates_.votes;
  const std::span<const QuarterMm> depth = candidates_.depth;
  const std::span<std::int16_t> wraps = support_.wraps.subspan(columns.begin, n);
  const std::span<std::uint16_t> comparable = support_.comparable.subspan(columns.begin, n);
  const std::int16_t now = static_cast<std::int16_t>(k);
  const std::uint16_t bit = static_cast<std::uint16_t>(1U << static_cast<unsigned>(k));
  const QuarterMm range = max_range_;
  for (std::size_t x = 0; x < possible.size(); ++x) {
    const std::uint16_t known = static_cast<std::uint16_t>(std::max(votes[x].known(), kLeastKnown));
    const std::uint16_t agree = static_cast<std::uint16_t>(votes[x].agree());
    const std::uint16_t apart = static_cast<std::uint16_t>(votes[x].apart());
    const bool supported =
        static_cast<std::uint16_t>(8 * agree) >= static_cast<std::uint16_t>(5 * known);
    const bool some = static_cast<std::uint16_t>(4 * agree) > known;
    wraps[x] = supported ? now : wraps[x];
    comparable[x] = static_cast<std::uint16_t>(comparable[x] + (some ? 1 : 0));
    // No depth, less one, is beyond any range.
    const bool within = static_cast<QuarterMm>(depth[x] - 1) < range;
    possible[x] = static_cast<std::uint16_t>(possible[x] | (within ? bit : 0));
    const bool far = static_cast<std::uint16_t>(4 * apart) >= known;
    mixed[x] = static_cast<std::uint16_t>(mixed[x] | (far ? bit : 0));
  }
}

void WrapEvidence::vote_row(int y, WrapMaps& maps) noexcept {
  const std::size_t first = maps.place(0, y);
  const auto [wraps, comparable] = support_;
  const std::span<const bool> bright = maps.bright.subspan(first, wraps.size());
  const std::span<const Reading> readings = maps.readings.subspan(first, wraps.size());
  const std::span<std::int8_t> votes = maps.vote.subspan(first, wraps.size());
  for (std::size_t x = 0; x < votes.size(); ++x) {
    // What is supported is comparable too.
    int vote = comparable[x] == 1 ? int{wraps[x]} : int{kUnknownWraps};
    vote = bright[x] ? 0 : vote;
    vote = readings[x].distance == kNoDepth ? int{kNoReading} : vote;
    votes[x] = static_cast<std::int8_t>(vote);
  }
}

void WrapEvidence::collect(const PmdMaps& pmd, ImageView<const Disparity> disparity,
                           const AmplitudeBound& bound, WrapMaps& maps) noexcept {
  samples_.take(disparity);
  std::ranges::fill(maps.possible, std::uint16_t{1});
  std::ranges::fill(maps.mixed, std::uint16_t{0});
  for (int y = 0; y < maps.height; ++y) {
    read_row(pmd, y, bound, maps);
    std::ranges::fill(support_.wraps, std::int16_t{kUnknownWraps});
    std::ranges::fill(support_.comparable, std::uint16_t{0});
    look_up(pmd.distance.row(y), pmd, y, 0);
    judge(y, 0, {0, index(maps.width)}, maps);
    for (int k = 1; k < maps.wrap_counts; ++k) {
      place_row(pmd, y, k, bound, maps);
      for (Columns c = next_columns(0); c.begin < c.end; c = next_columns(c.end)) {
        look_up(candidates_.distance.subspan(c.begin, c.end - c.begin), pmd, y, c.begin);
        judge(y, k, c, maps);
      }
    }
    vote_row(y, maps);
  }
}

}  // namespace stof::dsp

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

// One wrap count at a time, without branches, so that compilers make vectors of it.
void add_support(std::span<const Votes> votes, int k,
                 std::span<WrapEvidence::Support> support) noexcept {
  for (std::size_t x = 0; x < support.size(); ++x) {
    const int known = std::max(votes[x].known(), WrapEvidence::kLeastKnown);
    const int agree = votes[x].agree();
    const int comparable = 4 * agree > known ? 1 : 0;
    support[x].wraps =
        static_cast<std::int16_t>(8 * agree >= 5 * known ? k : int{support[x].wraps});
    support[x].comparable = static_cast<std::int16_t>(support[x].comparable + comparable);
  }
}

}  // namespace

// Bit k: within the range; much of what stereo sees lies far off it.
void WrapEvidence::mark_candidates(const Candidates& c, int k, QuarterMm max_range,
                                   std::span<std::uint16_t> possible,
                                   std::span<std::uint16_t> mixed) noexcept {
  const int bit = 1 << k;
  for (std::size_t x = 0; x < possible.size(); ++x) {
    const int known = std::max(c.votes[x].known(), kLeastKnown);
    // No depth, less one, is beyond any range.
    const bool within = static_cast<QuarterMm>(c.depth[x] - 1) < max_range;
    const bool apart = 4 * c.votes[x].apart() >= known;
    possible[x] = static_cast<std::uint16_t>(possible[x] | (within ? bit : 0));
    mixed[x] = static_cast<std::uint16_t>(mixed[x] | (apart ? bit : 0));
  }
}

WrapEvidence::WrapEvidence(const Calibration& calibration, const FusionParams& params,
                           int min_disparity, int disparities, int width, int height,
                           Arena& arena) noexcept
    : max_range_(params.max_range),
      samples_(calibration.stereo, params.stereo_sigma, min_disparity, disparities, width, height,
               footprint_of(calibration), arena),
      projection_(projection_of(calibration)),
      rays_(make_ray_table(calibration, arena)) {
  const std::size_t row = index(calibration.pmd.lens.width);
  support_ = arena.take<Support>(row);
  for (Candidates& c : candidates_) {
    c = {arena.take<QuarterMm>(row), arena.take<std::int32_t>(row), arena.take<std::int32_t>(row),
         arena.take<QuarterMm>(row), arena.take<QuarterMm>(row),    arena.take<Votes>(row)};
  }
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

// Where the readings of a row would lie by each wrap count that their amplitude allows, and what
// stereo says there.
void WrapEvidence::place_row(int y, QuarterMm far_off, const AmplitudeBound& bound,
                             WrapMaps& maps) noexcept {
  const std::size_t n = index(maps.width);
  const std::size_t first = maps.place(0, y);
  const RayRow rays = ray_row(rays_, maps.width, y);
  for (int k = 0; k < maps.wrap_counts; ++k) {
    const Candidates& c = candidates_[index(k)];
    for (std::size_t x = 0; x < n; ++x) {
      const std::size_t i = first + x;
      const Reading& reading = maps.readings[i];
      const std::uint32_t distance = maps.distance(i, k);
      const bool allowed =
          reading.distance != kNoDepth && distance <= kMaxQuarterMm &&
          (k == 0 || (!maps.bright[i] && (k == 1 || !bound.excludes(reading, distance))));
      c.distance[x] = allowed ? static_cast<QuarterMm>(distance) : kNoDepth;
    }
    best::project(rays, c.distance, projection_, c.u, c.v, c.depth);
    for (std::size_t x = 0; x < n; ++x) {
      // Two sigma, and what the calibration of both cameras may be off by.
      const int tolerance = 2 * maps.readings[first + x].sigma + c.depth[x] / 64;
      c.tolerance[x] = static_cast<QuarterMm>(std::min<int>(tolerance, kMaxQuarterMm));
    }
    best::count_votes({c.u, c.v, c.depth, c.tolerance}, samples_.grid(), far_off, c.votes);
  }
}

void WrapEvidence::judge_row(int y, WrapMaps& maps) noexcept {
  const std::size_t n = index(maps.width);
  const std::size_t first = maps.place(0, y);
  const std::span<std::uint16_t> possible = maps.possible.subspan(first, n);
  const std::span<std::uint16_t> mixed = maps.mixed.subspan(first, n);
  std::ranges::fill(possible, std::uint16_t{1});
  std::ranges::fill(mixed, std::uint16_t{0});
  std::ranges::fill(support_, Support{});
  for (int k = 0; k < maps.wrap_counts; ++k) {
    const Candidates& c = candidates_[index(k)];
    add_support(c.votes, k, support_);
    mark_candidates(c, k, max_range_, possible, mixed);
  }
  for (std::size_t x = 0; x < n; ++x) {
    // What is supported is comparable too.
    int vote = support_[x].comparable == 1 ? int{support_[x].wraps} : int{kUnknownWraps};
    vote = maps.bright[first + x] ? 0 : vote;
    vote = maps.readings[first + x].distance == kNoDepth ? int{kNoReading} : vote;
    maps.vote[first + x] = static_cast<std::int8_t>(vote);
  }
}

void WrapEvidence::collect(const PmdMaps& pmd, ImageView<const Disparity> disparity,
                           const AmplitudeBound& bound, WrapMaps& maps) noexcept {
  samples_.take(disparity);
  for (int y = 0; y < maps.height; ++y) {
    read_row(pmd, y, bound, maps);
    place_row(y, pmd.widest, bound, maps);
    judge_row(y, maps);
  }
}

}  // namespace stof::dsp

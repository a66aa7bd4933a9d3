#include "dsp/fusion/temporal/steady_row.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp {

void check_steady_row(const SteadyRow& row, const SteadyLimits& limits,
                      const SteadyState& state) noexcept {
  const std::size_t n = row.changed.size();
  STOF_CHECK(limits.max_range >= 1);
  STOF_CHECK(row.stereo.low.size() == n && row.stereo.high.size() == n);
  STOF_CHECK(row.pmd.low.size() == n && row.pmd.high.size() == n);
  STOF_CHECK(row.fused.depth.size() == n && row.fused.width.size() == n &&
             row.fused.source.size() == n && row.fused.cause.size() == n);
  STOF_CHECK(state.depth.size() == n && state.tally.size() == n);
}

namespace ref {
namespace {

constexpr int kTallyOne = 1 << kTallyBits;

struct Memory {
  int depth = 0;
  int known = 0;
  int votes = 0;
};

// A sensor's interval beside what is remembered.
struct Heard {
  int low;
  int high;
  bool says;
  bool confirms;

  Heard(const IntervalRow& row, std::size_t x, const Memory& memory,
        const SteadyLimits& limits) noexcept
      : low(std::max<int>(row.low[x], 1)),
        high(std::min<int>(row.high[x], limits.max_range)),
        says(low <= high) {
    const int reach = std::min<int>(memory.depth / 16, limits.max_step);
    confirms = says && low <= std::min(memory.depth + reach, int{kMaxQuarterMm}) &&
               high >= memory.depth - reach;
  }
  bool excludes() const noexcept { return says && !confirms; }
};

int mean(int a, int b) noexcept { return (a + b + 1) / 2; }

void put(const FusedRow& out, std::size_t x, int depth, int half, Source source,
         Cause cause) noexcept {
  out.depth[x] = static_cast<QuarterMm>(depth);
  out.width[x] = static_cast<QuarterMm>(2 * half);
  out.source[x] = source;
  out.cause[x] = cause;
}

// Publishes the interval about its depth nearest to what is remembered, which is returned.
int confirm(const FusedRow& out, std::size_t x, const Memory& memory, const Heard& heard,
            Source source) noexcept {
  const int depth = std::clamp(memory.depth, heard.low, heard.high);
  const int half = std::max(depth - heard.low, heard.high - depth);
  put(out, x, depth, std::min({half, depth - 1, kMaxQuarterMm - depth}), source, Cause::kNone);
  return depth;
}

Memory begun(int depth) noexcept {
  return depth == kNoDepth ? Memory{} : Memory{.depth = depth, .known = kSeenGain};
}

Memory next(const SteadyRow& row, const SteadyLimits& limits, std::size_t x,
            const Memory& old) noexcept {
  const int depth = row.fused.depth[x];
  const bool changed = (row.changed[x] & row.changes) != 0;
  if (old.known == 0 && !changed && row.fused.source[x] == Source::kResolved) {
    put(row.fused, x, kNoDepth, 0, Source::kNone, Cause::kNone);
  }
  if (old.known == 0 || changed) {
    return begun(depth);
  }
  const int more = std::min(old.known + kSeenGain, kMostTally);
  const int half = row.fused.width[x] / 2;
  const bool agrees = depth != kNoDepth && std::abs(depth - old.depth) <=
                                               std::min<int>(half + half / 2, limits.max_step);
  if (agrees) {
    return {.depth = mean(old.depth, mean(old.depth, depth)),
            .known = more,
            .votes = std::max(old.votes - 1, 0)};
  }
  const bool settled = old.known >= kSettled;
  if (settled && row.late != nullptr) {  // else nothing depends on them
    row.late->tell(*row.late, row.begin + x, row.begin + x + 1);
  }
  const Heard stereo(row.stereo, x, old, limits);
  const Heard pmd(row.pmd, x, old, limits);
  const bool confirmed = settled && (stereo.confirms || pmd.confirms);
  const bool near = depth < old.depth;
  int votes = old.votes;
  if (depth != kNoDepth) {
    votes = std::min(votes + (near ? kNearVotes : 1), kMostTally);
    const int to_far = confirmed ? kVotesToFarAgainst : kVotesToFar;
    const int enough = near ? kVotesToNear : to_far;
    if (!settled || (stereo.excludes() && pmd.excludes()) || votes >= enough) {
      return begun(depth);
    }
  }
  if (confirmed) {
    const int seen = stereo.confirms ? confirm(row.fused, x, old, stereo, Source::kStereo)
                                     : confirm(row.fused, x, old, pmd, Source::kPmd);
    return {.depth = seen, .known = more, .votes = votes};
  }
  if (depth != kNoDepth) {
    put(row.fused, x, kNoDepth, 0, Source::kConflict, Cause::kContradiction);
  }
  return {.depth = old.depth, .known = old.known - 1, .votes = votes};
}

}  // namespace

void steady_row(const SteadyRow& row, const SteadyLimits& limits,
                const SteadyState& state) noexcept {
  check_steady_row(row, limits, state);
  for (std::size_t x = 0; x < row.changed.size(); ++x) {
    const Memory memory = next(row, limits, x,
                               {.depth = state.depth[x],
                                .known = state.tally[x] % kTallyOne,
                                .votes = state.tally[x] / kTallyOne});
    state.depth[x] = static_cast<QuarterMm>(memory.depth);
    state.tally[x] = static_cast<std::uint8_t>(memory.known + kTallyOne * memory.votes);
  }
}

}  // namespace ref
}  // namespace stof::dsp

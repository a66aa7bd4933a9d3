#include "dsp/fusion/temporal/temporal_row.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp {

void check_temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                        const TemporalState& state) noexcept {
  const std::size_t n = row.depth.size();
  STOF_CHECK(row.changed.size() == n && row.source.size() == n && row.width.size() == n);
  STOF_CHECK(state.mean.size() == n && state.scatter.size() == n && state.tally.size() == n &&
             state.kind.size() == n);
  STOF_CHECK(limits.frames >= 1 && limits.frames <= kMostFrames && limits.max_step <= kMostStep);
}

namespace ref {
namespace {

constexpr int kSources = 8;
constexpr int kRuns = 4;

// Of one pixel, unpacked.
struct Memory {
  int mean16 = 0;  // 1/16 quarter mm
  int scatter = 0;
  int count = 0;
  int source = 0;
  int run = 0;
  bool away = false;
};

struct Measured {
  int depth;
  int half;
  int source;
};

int over(int value, int n) noexcept {
  const std::size_t at = static_cast<std::size_t>(n);
  return round_shift(value * (kReciprocals.low[at] + kReciprocals.high[at] * 256), kQ15Bits);
}

Memory load(const TemporalState& state, std::size_t x) noexcept {
  const int kind = state.kind[x];
  return {.mean16 = state.mean[x] * kMeanOne + state.tally[x] / kMeanOne,
          .scatter = state.scatter[x],
          .count = state.tally[x] % kMeanOne,
          .source = kind % kSources,
          .run = kind / kSources % kRuns,
          .away = kind / (kSources * kRuns) % 2 != 0};
}

void store(const Memory& memory, const TemporalState& state, std::size_t x) noexcept {
  const int run = memory.run + (memory.away ? kRuns : 0);
  state.mean[x] = static_cast<QuarterMm>(memory.mean16 / kMeanOne);
  state.scatter[x] = static_cast<std::uint16_t>(memory.scatter);
  state.tally[x] = static_cast<std::uint8_t>(memory.mean16 % kMeanOne * kMeanOne + memory.count);
  state.kind[x] = static_cast<std::uint8_t>(memory.source + kSources * run);
}

// The memory with the measurement in it; one frame in the mean where it began anew.
Memory next(const Memory& old, const Measured& now, bool changed,
            const TemporalLimits& limits) noexcept {
  if (now.depth == kNoDepth) {
    return {};
  }
  const int r = now.depth - old.mean16 / kMeanOne;
  const int apart = std::abs(r);
  const bool far = apart > now.half / 4;
  const bool longer = far && old.run > 0 && old.away == (r > 0);
  const int run = far ? 1 + (longer ? old.run : 0) : 0;
  const int gate = std::min<int>(now.half + now.half / 2, limits.max_step);
  if (changed || old.count == 0 || old.source != now.source || apart > gate || run >= kRestartRun) {
    return {.mean16 = now.depth * kMeanOne, .count = 1, .source = now.source % kSources};
  }
  const int count = std::min<int>(old.count + 1, limits.frames);
  return {.mean16 = old.mean16 + over(now.depth * kMeanOne - old.mean16, count),
          .scatter = old.scatter + over(apart * kMeanOne - old.scatter, old.count),
          .count = count,
          .source = old.source,
          .run = run,
          .away = far && r > 0};
}

int narrowed(int half, const Memory& memory) noexcept {
  if (memory.count < kFramesToNarrow || memory.run >= 2) {
    return half;
  }
  const int scatter = memory.scatter / kMeanOne;
  const int noise = 2 * scatter + scatter / 4 + scatter / 8;
  return std::clamp(half + half / 2 + half / 4 - noise, half - half / 2, half);
}

int published(const Measured& now, int half, const Memory& memory) noexcept {
  if (memory.count < kFramesToAverage || memory.run >= kRestartRun - 1) {
    return now.depth;
  }
  const int mean = round_shift(memory.mean16, kMeanBits);
  return std::clamp(mean, std::max(now.depth - now.half / 2, std::min(now.depth, half)),
                    std::min(now.depth + now.half / 2, std::max(now.depth, kMaxQuarterMm - half)));
}

}  // namespace

void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                  const TemporalState& state) noexcept {
  check_temporal_row(row, limits, state);
  for (std::size_t x = 0; x < row.depth.size(); ++x) {
    const Measured now{
        .depth = row.depth[x], .half = row.width[x] / 2, .source = static_cast<int>(row.source[x])};
    const Memory memory = next(load(state, x), now, row.changed[x] != 0, limits);
    store(memory, state, x);
    if (memory.count != 0) {
      const int half = narrowed(now.half, memory);
      row.depth[x] = static_cast<QuarterMm>(published(now, half, memory));
      row.width[x] = static_cast<QuarterMm>(row.width[x] - 2 * (now.half - half));
    }
  }
}

}  // namespace ref
}  // namespace stof::dsp

#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/fusion/temporal/temporal_row.h"

// The vector variants of temporal_row.h; what is static here must not be shared with files for
// other processors. Isa: Lanes<std::uint16_t> of base/lanes_neon.h or lanes_avx2.h.
namespace stof::dsp::temporal_row_body {

template <typename Isa>
class Body {
 public:
  // Isa::kLanes pixels from x on.
  static void some(const TemporalRow& row, const TemporalLimits& limits, const TemporalState& state,
                   std::size_t x) noexcept {
    const auto* const sources =
        reinterpret_cast<const std::uint8_t*>(row.source.data());  // NOLINT: bytes
    Pixels p{.changed = Isa::load_bytes(row.changed.data() + x),
             .source = Isa::load_bytes(sources + x),
             .depth = Isa::load(row.depth.data() + x),
             .width = Isa::load(row.width.data() + x),
             .tally = Isa::load_bytes(state.tally.data() + x),
             .kind = Isa::load_bytes(state.kind.data() + x),
             .mean = Isa::load(state.mean.data() + x),
             .scatter = Isa::load(state.scatter.data() + x)};
    advance(limits, p);
    Isa::store(row.depth.data() + x, p.depth);
    Isa::store(row.width.data() + x, p.width);
    Isa::store(state.mean.data() + x, p.mean);
    Isa::store(state.scatter.data() + x, p.scatter);
    Isa::store_bytes(state.tally.data() + x, p.tally);
    Isa::store_bytes(state.kind.data() + x, p.kind);
  }

 private:
  using V = typename Isa::V;

  // Fields of TemporalState::kind.
  static constexpr int kSourceMask = 7;
  static constexpr int kRunShift = 3;
  static constexpr int kRunMask = 3;
  static constexpr int kAwayShift = 5;

  struct Pixels {
    V changed;
    V source;
    V depth;
    V width;
    V tally;
    V kind;
    V mean;
    V scatter;
  };

  static V all(int value) noexcept { return Isa::all(static_cast<std::uint16_t>(value)); }
  static V over(V a, V b) noexcept { return Isa::subtract_saturated(a, b); }
  // 1 where v is not 0, else 0; and as a mask. Conditions are kept as numbers that are 0 where they
  // hold, so that one comparison judges many.
  static V one_of(V v) noexcept { return Isa::smaller(v, all(1)); }
  static V mask_of(V one) noexcept { return all(0) - one; }
  static V is_zero(V v) noexcept { return Isa::equal(v, all(0)); }

  static V reciprocal(V n) noexcept {
    return Isa::look_up(kReciprocals.low, n) | (Isa::look_up(kReciprocals.high, n) << 8);
  }

  // half', see temporal_row.h.
  static V narrowed(V half, V scatter16, V calm) noexcept {
    const V scatter = scatter16 >> kMeanBits;
    const V noise = (scatter << 1) + (scatter >> 2) + (scatter >> 3);
    const V loud = half + (half >> 1) + (half >> 2);
    const V least = half - (half >> 1);
    const V narrow = Isa::smaller(half, Isa::larger(Isa::subtract_saturated(loud, noise), least));
    return Isa::select(calm, narrow, half);
  }

  static V limited(V mean, V depth, V reach, V half) noexcept {
    const V least = Isa::larger(Isa::subtract_saturated(depth, reach), Isa::smaller(depth, half));
    const V most = Isa::smaller(Isa::add_saturated(depth, reach),
                                Isa::larger(depth, all(kMaxQuarterMm) - half));
    return Isa::smaller(Isa::larger(mean, least), most);
  }

  // Writes what becomes of depth, width, mean, scatter, tally and kind.
  static void advance(const TemporalLimits& limits, Pixels& p) noexcept {
    const V half = p.width >> 1;
    const V half_of_it = half >> 1;
    const V frames = p.tally & all(kMeanOne - 1);
    const V fraction = p.tally >> kMeanBits;
    const V count = Isa::smaller(frames + all(1), all(limits.frames));
    const V apart = Isa::difference(p.depth, p.mean);
    const V away = one_of(over(p.depth, p.mean));
    const V far = mask_of(one_of(over(apart, half >> 2)));
    const V turned = ((p.kind >> kAwayShift) & all(1)) ^ away;
    const V old_run = (p.kind >> kRunShift) & all(kRunMask) & (turned - all(1));
    const V run = far & (old_run + all(1));

    const V some = one_of(p.depth);
    const V gate = Isa::smaller(half + half_of_it, all(limits.max_step));
    const V ends = p.changed | ((p.kind & all(kSourceMask)) ^ p.source) | over(apart, gate) |
                   over(run, all(kRestartRun - 1)) | (one_of(frames) ^ all(1)) | (some ^ all(1));
    const V keep = is_zero(ends);

    // Below 2^15 where the mean goes on: |r| <= kMostStep.
    const V r16 = ((p.depth - p.mean) << kMeanBits) - fraction;
    const V moved = fraction + Isa::signed_scaled_product(r16, reciprocal(count));
    const V mean = p.mean + Isa::signed_sixteenth(moved);
    const V rest = moved & all(kMeanOne - 1);
    const V louder = (apart << kMeanBits) - p.scatter;
    const V scatter = p.scatter + Isa::signed_scaled_product(louder, reciprocal(frames));

    const V calm = is_zero(ends | over(all(kFramesToNarrow), count) | over(run, all(1)));
    const V publish =
        is_zero(ends | over(all(kFramesToAverage), count) | over(run, all(kRestartRun - 2)));
    const V new_half = narrowed(half, scatter, calm);
    const V rounded = mean + (rest >> (kMeanBits - 1));
    const V out = limited(rounded, p.depth, half_of_it, new_half);

    const V measured = mask_of(some);
    const V run_bits = (run << kRunShift) | (far & (away << kAwayShift));
    p.kind = ((p.source & all(kSourceMask)) | (keep & run_bits)) & measured;
    p.tally = Isa::select(keep, (rest << kMeanBits) | count, all(1)) & measured;
    p.mean = Isa::select(keep, mean, p.depth);
    p.scatter = keep & scatter;
    p.depth = Isa::select(publish, out, p.depth);
    p.width = p.width - ((half - new_half) << 1);
  }
};

// Tells how many pixels are done. Values, not references: no store can change them, so they stay in
// registers.
template <typename Isa>
static std::size_t whole_vectors(TemporalRow row, TemporalLimits limits,
                                 TemporalState state) noexcept {
  std::size_t x = 0;
  for (; x + Isa::kLanes <= row.depth.size(); x += Isa::kLanes) {
    Body<Isa>::some(row, limits, state, x);
  }
  return x;
}

// What is left goes to `narrower`.
template <typename Isa>
static void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                         const TemporalState& state, TemporalRowKernel& narrower) noexcept {
  check_temporal_row(row, limits, state);
  const std::size_t x = whole_vectors<Isa>(row, limits, state);
  narrower({.changed = row.changed.subspan(x),
            .source = row.source.subspan(x),
            .depth = row.depth.subspan(x),
            .width = row.width.subspan(x)},
           limits,
           {.mean = state.mean.subspan(x),
            .scatter = state.scatter.subspan(x),
            .tally = state.tally.subspan(x),
            .kind = state.kind.subspan(x)});
}

}  // namespace stof::dsp::temporal_row_body

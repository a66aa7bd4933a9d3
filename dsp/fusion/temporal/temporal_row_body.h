#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/fusion/temporal/temporal_row.h"

// The vector variants of temporal_row.h; what is static here must not be shared with files for
// other processors. What fits a byte is computed for twice as many pixels at once. Isa:
//   Words, Bytes             as Lanes<> of base/lanes_neon.h, of u16 and u8
//   load_bytes, store_bytes  bytes in an order that the next ones know
//   as_bytes                 lanes of -128 .. 127 of two vectors
//   lower, upper             low + 256 high of the first half of the bytes, of the second one
//   lower_mask, upper_mask   the same of masks
//   look_up                  table[v] of values below 16
namespace stof::dsp::temporal_row_body {

template <typename Isa>
class Body {
 public:
  static constexpr std::size_t kPixels = 2 * Isa::Words::kLanes;

  // kPixels pixels from x on.
  static void some(const TemporalRow& row, const TemporalLimits& limits, const TemporalState& state,
                   std::size_t x) noexcept {
    const auto* const sources =
        reinterpret_cast<const std::uint8_t*>(row.source.data());  // NOLINT: bytes
    Pixels lower = load(row, state, x);
    Pixels upper = load(row, state, x + Words::kLanes);
    const Apart lows = compare(limits, lower);
    const Apart highs = compare(limits, upper);
    const B tally = Isa::load_bytes(state.tally.data() + x);
    const B frames = tally & byte(kMeanOne - 1);
    const B fraction = tally >> kMeanBits;
    const B source = Isa::load_bytes(sources + x);
    const Decision now = decide(limits, Isa::load_bytes(row.changed.data() + x), source, frames,
                                Isa::load_bytes(state.kind.data() + x),
                                {.near = Isa::as_bytes(lows.near, highs.near),
                                 .toward = Isa::as_bytes(lows.toward, highs.toward),
                                 .inside = Isa::as_bytes(lows.inside, highs.inside),
                                 .none = Isa::as_bytes(lows.none, highs.none)});
    const Factors old_share = reciprocals(frames);
    const Factors new_share = reciprocals(now.count);
    const B zero = byte(0);
    const V low_rest = advance({.keep = Isa::lower_mask(now.keep),
                                .calm = Isa::lower_mask(now.calm),
                                .publish = Isa::lower_mask(now.publish),
                                .fraction = Isa::lower(fraction, zero),
                                .old_share = old_share.lower,
                                .new_share = new_share.lower},
                               lower);
    const V high_rest = advance({.keep = Isa::upper_mask(now.keep),
                                 .calm = Isa::upper_mask(now.calm),
                                 .publish = Isa::upper_mask(now.publish),
                                 .fraction = Isa::upper(fraction, zero),
                                 .old_share = old_share.upper,
                                 .new_share = new_share.upper},
                                upper);
    const B rest = Isa::as_bytes(low_rest, high_rest);
    const B going_on = (rest << kMeanBits) | now.count;
    store(row, state, x, lower);
    store(row, state, x + Words::kLanes, upper);
    Isa::store_bytes(state.tally.data() + x,
                     Bytes::select(now.keep, going_on, byte(1)) & ~now.none);
    Isa::store_bytes(state.kind.data() + x, now.kind);
  }

 private:
  using Words = typename Isa::Words;
  using Bytes = typename Isa::Bytes;
  using V = typename Words::V;
  using B = typename Bytes::V;

  // Fields of TemporalState::kind. A run is counted where it stands there.
  static constexpr int kSourceMask = 7;
  static constexpr int kRunOne = 8;
  static constexpr int kRunMask = 3 * kRunOne;
  static constexpr int kAway = 32;

  struct Pixels {
    V depth;
    V width;
    V mean;
    V scatter;
  };

  // How a measurement stands to the mean; masks.
  template <typename Mask>
  struct Standing {
    Mask near;    // not far
    Mask toward;  // not away from the camera
    Mask inside;  // the gate
    Mask none;    // no depth
  };
  using Apart = Standing<V>;

  // Masks, but for the last two.
  struct Decision {
    B keep;
    B calm;
    B publish;
    B none;
    B count;
    B kind;
  };

  struct Factors {
    V lower;
    V upper;
  };

  // What is known of pixels before their mean is.
  struct Known {
    V keep;
    V calm;
    V publish;
    V fraction;
    V old_share;
    V new_share;
  };

  static V all(int value) noexcept { return Words::all(static_cast<std::uint16_t>(value)); }
  static B byte(int value) noexcept { return Bytes::all(static_cast<std::uint8_t>(value)); }
  static B at_most(B a, int b) noexcept { return Bytes::at_most(a, byte(b)); }
  static B at_least(B a, int b) noexcept { return Bytes::at_most(byte(b), a); }
  static B is_zero(B v) noexcept { return Bytes::equal(v, byte(0)); }

  static Pixels load(const TemporalRow& row, const TemporalState& state, std::size_t x) noexcept {
    return {.depth = Words::load(row.depth.data() + x),
            .width = Words::load(row.width.data() + x),
            .mean = Words::load(state.mean.data() + x),
            .scatter = Words::load(state.scatter.data() + x)};
  }
  static void store(const TemporalRow& row, const TemporalState& state, std::size_t x,
                    const Pixels& p) noexcept {
    Words::store(row.depth.data() + x, p.depth);
    Words::store(row.width.data() + x, p.width);
    Words::store(state.mean.data() + x, p.mean);
    Words::store(state.scatter.data() + x, p.scatter);
  }

  static Apart compare(const TemporalLimits& limits, const Pixels& p) noexcept {
    const V half = p.width >> 1;
    const V apart = Words::difference(p.depth, p.mean);
    const V gate = Words::smaller(half + (half >> 1), all(limits.max_step));
    return {.near = Words::at_most(apart, half >> 2),
            .toward = Words::at_most(p.depth, p.mean),
            .inside = Words::at_most(apart, gate),
            .none = Words::equal(p.depth, all(0))};
  }

  static Decision decide(const TemporalLimits& limits, B changed, B source, B frames, B kind,
                         const Standing<B>& is) noexcept {
    const B count = Bytes::smaller(frames + byte(1), byte(limits.frames));
    const B same_side = Bytes::equal((kind ^ is.toward) & byte(kAway), byte(kAway));
    const B run = ((kind & byte(kRunMask) & same_side) + byte(kRunOne)) & ~is.near;
    const B stays = is_zero(changed | ((kind & byte(kSourceMask)) ^ source));
    const B keep = stays & is.inside & ~(is.none | is_zero(frames)) &
                   at_most(run, (kRestartRun - 1) * kRunOne);
    const B run_bits = run | (byte(kAway) & ~(is.near | is.toward));
    return {.keep = keep,
            .calm = keep & at_least(count, kFramesToNarrow) & at_most(run, kRunOne),
            .publish = keep & at_least(count, kFramesToAverage) &
                       at_most(run, (kRestartRun - 2) * kRunOne),
            .none = is.none,
            .count = count,
            .kind = ((source & byte(kSourceMask)) | (keep & run_bits)) & ~is.none};
  }

  static Factors reciprocals(B n) noexcept {
    const B low = Isa::look_up(kReciprocals.low, n);
    const B high = Isa::look_up(kReciprocals.high, n);
    return {Isa::lower(low, high), Isa::upper(low, high)};
  }

  // half', see temporal_row.h.
  static V narrowed(V half, V scatter16, V calm) noexcept {
    const V scatter = scatter16 >> kMeanBits;
    const V noise = ((scatter << 1) + (scatter >> 2) + (scatter >> 3)) & calm;
    const V loud = half + (half >> 1) + (half >> 2);
    const V least = half - (half >> 1);
    return Words::smaller(half, Words::larger(Words::subtract_saturated(loud, noise), least));
  }

  static V limited(V mean, V depth, V reach, V half) noexcept {
    const V least =
        Words::larger(Words::subtract_saturated(depth, reach), Words::smaller(depth, half));
    const V most = Words::smaller(Words::add_saturated(depth, reach),
                                  Words::larger(depth, all(kMaxQuarterMm) - half));
    return Words::smaller(Words::larger(mean, least), most);
  }

  // Writes what becomes of depth, width, mean and scatter; gives the new fraction of the mean.
  static V advance(const Known& known, Pixels& p) noexcept {
    const V half = p.width >> 1;
    const V apart = Words::difference(p.depth, p.mean);
    // Below 2^15 where the mean goes on: |r| <= kMostStep.
    const V r16 = ((p.depth - p.mean) << kMeanBits) - known.fraction;
    const V moved = known.fraction + Words::signed_scaled_product(r16, known.new_share);
    const V mean = p.mean + Words::signed_sixteenth(moved);
    const V rounded = p.mean + Words::signed_sixteenth(moved + all(kMeanOne / 2));
    const V louder = (apart << kMeanBits) - p.scatter;
    const V scatter = p.scatter + Words::signed_scaled_product(louder, known.old_share);

    const V new_half = narrowed(half, scatter, known.calm);
    const V out = limited(rounded, p.depth, half >> 1, new_half);
    p.mean = Words::select(known.keep, mean, p.depth);
    p.scatter = known.keep & scatter;
    p.depth = Words::select(known.publish, out, p.depth);
    p.width = p.width - ((half - new_half) << 1);
    return moved & all(kMeanOne - 1);
  }
};

// Tells how many pixels are done. Values, not references: no store can change them, so they stay in
// registers.
template <typename Isa>
static std::size_t whole_vectors(TemporalRow row, TemporalLimits limits,
                                 TemporalState state) noexcept {
  std::size_t x = 0;
  for (; x + Body<Isa>::kPixels <= row.depth.size(); x += Body<Isa>::kPixels) {
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

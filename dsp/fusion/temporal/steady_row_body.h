#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/fusion/temporal/steady_row.h"

// The vector variants of steady_row.h; what is static here must not be shared with files for other
// processors. Isa: Lanes<std::uint16_t> of base/lanes_neon.h or lanes_avx2.h.
namespace stof::dsp::steady_row_body {

template <typename Isa>
class Body {
 public:
  // Isa::kLanes pixels from x on.
  static void some(const SteadyRow& row, const SteadyLimits& limits, const SteadyState& state,
                   std::size_t x) noexcept {
    const FusedRow& fused = row.fused;
    const V tally = Isa::load_bytes(state.tally.data() + x);
    Pixels p{.depth = Isa::load(fused.depth.data() + x),
             .width = Isa::load(fused.width.data() + x),
             .source = Isa::load_bytes(bytes(fused.source) + x),
             .cause = {},
             .seen = Isa::load(state.depth.data() + x),
             .known = tally & all(kMostTally),
             .votes = tally >> kTallyBits};
    const V unchanged = is_zero(Isa::load_bytes(row.changed.data() + x) & all(row.changes));
    const Standing is = compare(p, unchanged, limits);
    if (Isa::any(is.other | is.appears)) {
      p.cause = Isa::load_bytes(bytes(fused.cause) + x);
      advance(row, limits, x, is, p);
      Isa::store(fused.depth.data() + x, p.depth);
      Isa::store(fused.width.data() + x, p.width);
      Isa::store_bytes(bytes(fused.source) + x, p.source);
      Isa::store_bytes(bytes(fused.cause) + x, p.cause);
    } else {
      advance_alike(is, p);
    }
    Isa::store(state.depth.data() + x, p.seen);
    Isa::store_bytes(state.tally.data() + x, p.known | (p.votes << kTallyBits));
  }

 private:
  using V = typename Isa::V;

  struct Pixels {
    V depth;
    V width;
    V source;
    V cause;
    V seen;
    V known;
    V votes;
  };

  // A sensor's intervals beside what is remembered; masks.
  struct Heard {
    V low;
    V high;
    V confirms;
    V excludes;
  };

  // How a frame's depths stand to what is remembered; masks.
  struct Standing {
    V known;
    V some;
    V agrees;
    V other;    // known, and no depth that agrees
    V appears;  // waits for the next frame
  };

  static V all(int value) noexcept { return Isa::all(static_cast<std::uint16_t>(value)); }
  static V is_zero(V v) noexcept { return Isa::equal(v, all(0)); }
  static V one_of(Source source) noexcept { return all(static_cast<int>(source)); }
  template <typename T>
  static std::uint8_t* bytes(std::span<T> values) noexcept {
    return reinterpret_cast<std::uint8_t*>(values.data());  // NOLINT: bytes
  }

  static Heard hear(const IntervalRow& row, std::size_t x, V seen,
                    const SteadyLimits& limits) noexcept {
    const V reach = Isa::smaller(seen >> 4, all(limits.max_step));
    const V low = Isa::larger(Isa::load(row.low.data() + x), all(1));
    const V high = Isa::smaller(Isa::load(row.high.data() + x), all(limits.max_range));
    const V says = Isa::at_most(low, high);
    const V meets =
        Isa::at_most(low, Isa::add_saturated(seen, reach)) & Isa::at_most(seen - reach, high);
    return {low, high, says & meets, says & ~meets};
  }

  static Standing compare(const Pixels& p, V unchanged, const SteadyLimits& limits) noexcept {
    const V known = unchanged & ~is_zero(p.known);
    const V some = ~is_zero(p.depth);
    const V half = p.width >> 1;
    const V gate = Isa::smaller(half + (half >> 1), all(limits.max_step));
    const V close = Isa::at_most(Isa::difference(p.depth, p.seen), gate);
    const V agrees = known & some & close;
    const V resolved = Isa::equal(p.source, one_of(Source::kResolved));
    return {known, some, agrees, known & ~agrees, unchanged & is_zero(p.known) & resolved};
  }

  static V better_known(V known) noexcept {
    return Isa::smaller(known + all(kSeenGain), all(kMostTally));
  }
  static V moved_towards(V depth, V seen) noexcept {
    return Isa::rounded_mean(seen, Isa::rounded_mean(seen, depth));
  }

  // What is remembered where every depth agrees or begins: it is published as it is.
  static void advance_alike(const Standing& is, Pixels& p) noexcept {
    p.seen = Isa::select(is.agrees, moved_towards(p.depth, p.seen), p.depth);
    p.known = Isa::select(is.agrees, better_known(p.known), is.some & all(kSeenGain));
    p.votes = is.agrees & Isa::subtract_saturated(p.votes, all(1));
  }

  // As ref::next().
  static void advance(const SteadyRow& row, const SteadyLimits& limits, std::size_t x,
                      const Standing& is, Pixels& p) noexcept {
    const V differs = is.other & is.some;
    const V settled = is.known & Isa::at_most(all(kSettled), p.known);
    Heard stereo{all(0), all(0), all(0), all(0)};
    Heard pmd = stereo;
    if (Isa::any(is.other & settled)) {  // else nothing depends on them: they stay where they are
      if (row.late != nullptr) {
        row.late->tell(*row.late, row.begin + x, row.begin + x + Isa::kLanes);
      }
      stereo = hear(row.stereo, x, p.seen, limits);
      pmd = hear(row.pmd, x, p.seen, limits);
    }
    const V could = is.other & settled & (stereo.confirms | pmd.confirms);

    const V near = ~Isa::at_most(p.seen, p.depth);
    const V gain = Isa::select(near, all(kNearVotes), all(1));
    const V against = Isa::select(differs, Isa::smaller(p.votes + gain, all(kMostTally)), p.votes);
    const V enough = Isa::select(near, all(kVotesToNear),
                                 Isa::select(could, all(kVotesToFarAgainst), all(kVotesToFar)));
    const V outvoted = (stereo.excludes & pmd.excludes) | Isa::at_most(enough, against);
    const V begins = ~is.known | (differs & (outvoted | ~settled));
    const V confirmed = could & ~begins;
    const V withheld = differs & ~begins & ~confirmed;

    const V low = Isa::select(stereo.confirms, stereo.low, pmd.low);
    const V high = Isa::select(stereo.confirms, stereo.high, pmd.high);
    const V nearest = Isa::smaller(Isa::larger(p.seen, low), high);
    const V widest = Isa::larger(nearest - low, high - nearest);
    const V room = Isa::smaller(nearest - all(1), all(kMaxQuarterMm) - nearest);
    const V width = Isa::smaller(widest, room) << 1;

    const V kept = Isa::select(is.agrees | confirmed, better_known(p.known),
                               Isa::subtract_saturated(p.known, all(1)));
    const V seen = Isa::select(is.agrees, moved_towards(p.depth, p.seen),
                               Isa::select(confirmed, nearest, p.seen));
    p.seen = Isa::select(begins, p.depth, seen);
    p.known = Isa::select(begins, is.some & all(kSeenGain), kept);
    p.votes = Isa::select(is.agrees, Isa::subtract_saturated(p.votes, all(1)), against) & ~begins;
    const V nothing = withheld | is.appears;
    p.depth = Isa::select(confirmed, nearest, p.depth) & ~nothing;
    p.width = Isa::select(confirmed, width, p.width) & ~nothing;
    const V confirmer = Isa::select(stereo.confirms, one_of(Source::kStereo), one_of(Source::kPmd));
    p.source =
        Isa::select(confirmed, confirmer,
                    Isa::select(withheld, one_of(Source::kConflict), p.source & ~is.appears));
    p.cause = Isa::select(withheld, all(static_cast<int>(Cause::kContradiction)),
                          p.cause & ~(confirmed | is.appears));
  }
};

// Tells how many pixels are done. Values, not references: no store can change them, so they stay in
// registers.
template <typename Isa>
static std::size_t whole_vectors(SteadyRow row, SteadyLimits limits, SteadyState state) noexcept {
  std::size_t x = 0;
  for (; x + Isa::kLanes <= row.changed.size(); x += Isa::kLanes) {
    Body<Isa>::some(row, limits, state, x);
  }
  return x;
}

// What is left goes to `narrower`.
template <typename Isa>
static void steady_row(const SteadyRow& row, const SteadyLimits& limits, const SteadyState& state,
                       SteadyRowKernel& narrower) noexcept {
  check_steady_row(row, limits, state);
  const std::size_t x = whole_vectors<Isa>(row, limits, state);
  const auto tail = [x](const IntervalRow& of) noexcept {
    return IntervalRow{of.low.subspan(x), of.high.subspan(x)};
  };
  narrower({.changed = row.changed.subspan(x),
            .changes = row.changes,
            .stereo = tail(row.stereo),
            .pmd = tail(row.pmd),
            .fused = {row.fused.depth.subspan(x), row.fused.width.subspan(x),
                      row.fused.source.subspan(x), row.fused.cause.subspan(x)},
            .late = row.late,
            .begin = row.begin + x},
           limits, {.depth = state.depth.subspan(x), .tally = state.tally.subspan(x)});
}

}  // namespace stof::dsp::steady_row_body

#include "dsp/fusion/temporal/steady_row.h"

#include <cstddef>

#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

uint16x8_t all(int value) noexcept { return vdupq_n_u16(static_cast<std::uint16_t>(value)); }
uint16x8_t choose(uint16x8_t mask, uint16x8_t a, uint16x8_t b) noexcept {
  return vbslq_u16(mask, a, b);
}
uint16x8_t one_of(Source source) noexcept { return all(static_cast<int>(source)); }

// Eight pixels of SteadyRow and SteadyState.
struct Pixels {
  uint16x8_t depth;
  uint16x8_t width;
  uint16x8_t source;
  uint16x8_t cause;
  uint16x8_t seen;
  uint16x8_t known;
  uint16x8_t votes;
};

// A sensor's intervals beside what is remembered; masks.
struct Heard {
  uint16x8_t low;
  uint16x8_t high;
  uint16x8_t confirms;
  uint16x8_t excludes;
};

Heard hear(const IntervalRow& row, std::size_t x, uint16x8_t seen,
           const SteadyLimits& limits) noexcept {
  const uint16x8_t reach = vminq_u16(vshrq_n_u16(seen, 4), all(limits.max_step));
  const uint16x8_t low = vmaxq_u16(vld1q_u16(row.low.data() + x), all(1));
  const uint16x8_t high = vminq_u16(vld1q_u16(row.high.data() + x), all(limits.max_range));
  const uint16x8_t says = vcleq_u16(low, high);
  const uint16x8_t meets =
      vandq_u16(vcleq_u16(low, vqaddq_u16(seen, reach)), vcgeq_u16(high, vsubq_u16(seen, reach)));
  return {low, high, vandq_u16(says, meets), vbicq_u16(says, meets)};
}

// How a frame's depths stand to what is remembered; masks.
struct Standing {
  uint16x8_t known;
  uint16x8_t some;
  uint16x8_t agrees;
  uint16x8_t other;  // known, and no depth that agrees
};

Standing compare(const Pixels& p, uint16x8_t changed, const SteadyLimits& limits) noexcept {
  const uint16x8_t known = vbicq_u16(vtstq_u16(p.known, p.known), changed);
  const uint16x8_t some = vtstq_u16(p.depth, p.depth);
  const uint16x8_t half = vshrq_n_u16(p.width, 1);
  const uint16x8_t gate = vminq_u16(vaddq_u16(half, vshrq_n_u16(half, 1)), all(limits.max_step));
  const uint16x8_t close = vcleq_u16(vabdq_u16(p.depth, p.seen), gate);
  const uint16x8_t agrees = vandq_u16(vandq_u16(known, some), close);
  return {known, some, agrees, vbicq_u16(known, agrees)};
}

uint16x8_t better_known(uint16x8_t known) noexcept {
  return vminq_u16(vaddq_u16(known, all(kSeenGain)), all(kMostTally));
}
uint16x8_t moved_towards(uint16x8_t depth, uint16x8_t seen) noexcept {
  return vrhaddq_u16(seen, vrhaddq_u16(seen, depth));
}

// What is remembered where every depth agrees or begins: it is published as it is.
void advance_alike(const Standing& is, Pixels& p) noexcept {
  p.seen = choose(is.agrees, moved_towards(p.depth, p.seen), p.depth);
  p.known = choose(is.agrees, better_known(p.known), vandq_u16(is.some, all(kSeenGain)));
  p.votes = vandq_u16(is.agrees, vqsubq_u16(p.votes, all(1)));
}

// As ref::next().
void advance(const SteadyRow& row, const SteadyLimits& limits, std::size_t x, const Standing& is,
             Pixels& p) noexcept {
  const uint16x8_t differs = vandq_u16(is.other, is.some);
  const uint16x8_t settled = vandq_u16(is.known, vcgeq_u16(p.known, all(kSettled)));
  const Heard stereo = hear(row.stereo, x, p.seen, limits);
  const Heard pmd = hear(row.pmd, x, p.seen, limits);
  const uint16x8_t could =
      vandq_u16(vandq_u16(is.other, settled), vorrq_u16(stereo.confirms, pmd.confirms));

  const uint16x8_t near = vcltq_u16(p.depth, p.seen);
  const uint16x8_t gain = choose(near, all(kNearVotes), all(1));
  const uint16x8_t against =
      choose(differs, vminq_u16(vaddq_u16(p.votes, gain), all(kMostTally)), p.votes);
  const uint16x8_t enough =
      choose(near, all(kVotesToNear), choose(could, all(kVotesToFarAgainst), all(kVotesToFar)));
  const uint16x8_t both = vandq_u16(stereo.excludes, pmd.excludes);
  const uint16x8_t outvoted = vorrq_u16(both, vcgeq_u16(against, enough));
  const uint16x8_t begins =
      vorrq_u16(vmvnq_u16(is.known), vandq_u16(differs, vornq_u16(outvoted, settled)));
  const uint16x8_t confirmed = vbicq_u16(could, begins);
  const uint16x8_t withheld = vbicq_u16(vbicq_u16(differs, begins), confirmed);

  const uint16x8_t low = choose(stereo.confirms, stereo.low, pmd.low);
  const uint16x8_t high = choose(stereo.confirms, stereo.high, pmd.high);
  const uint16x8_t nearest = vminq_u16(vmaxq_u16(p.seen, low), high);
  const uint16x8_t widest = vmaxq_u16(vsubq_u16(nearest, low), vsubq_u16(high, nearest));
  const uint16x8_t room =
      vminq_u16(vsubq_u16(nearest, all(1)), vsubq_u16(all(kMaxQuarterMm), nearest));
  const uint16x8_t width = vshlq_n_u16(vminq_u16(widest, room), 1);

  const uint16x8_t gains = vorrq_u16(is.agrees, confirmed);
  const uint16x8_t kept = choose(gains, better_known(p.known), vqsubq_u16(p.known, all(1)));
  const uint16x8_t seen =
      choose(is.agrees, moved_towards(p.depth, p.seen), choose(confirmed, nearest, p.seen));
  p.seen = choose(begins, p.depth, seen);
  p.known = choose(begins, vandq_u16(is.some, all(kSeenGain)), kept);
  p.votes = vbicq_u16(choose(is.agrees, vqsubq_u16(p.votes, all(1)), against), begins);
  p.depth = vbicq_u16(choose(confirmed, nearest, p.depth), withheld);
  p.width = vbicq_u16(choose(confirmed, width, p.width), withheld);
  const uint16x8_t confirmer =
      choose(stereo.confirms, one_of(Source::kStereo), one_of(Source::kPmd));
  p.source = choose(confirmed, confirmer, choose(withheld, one_of(Source::kConflict), p.source));
  p.cause =
      choose(withheld, all(static_cast<int>(Cause::kContradiction)), vbicq_u16(p.cause, confirmed));
}

bool any(uint16x8_t mask) noexcept {
  const uint64x2_t words = vreinterpretq_u64_u16(mask);
  return (vgetq_lane_u64(words, 0) | vgetq_lane_u64(words, 1)) != 0;
}

template <typename T>
uint16x8_t load_bytes(std::span<T> bytes, std::size_t x) noexcept {
  return vmovl_u8(
      vld1_u8(reinterpret_cast<const std::uint8_t*>(bytes.data() + x)));  // NOLINT: bytes
}
template <typename T>
void store_bytes(std::span<T> bytes, std::size_t x, uint16x8_t value) noexcept {
  vst1_u8(reinterpret_cast<std::uint8_t*>(bytes.data() + x), vmovn_u16(value));  // NOLINT: bytes
}

void eight(const SteadyRow& row, const SteadyLimits& limits, const SteadyState& state,
           std::size_t x) noexcept {
  const FusedRow& fused = row.fused;
  const uint16x8_t tally = load_bytes(state.tally, x);
  const uint16x8_t changes = load_bytes(row.changed, x);
  Pixels p{.depth = vld1q_u16(fused.depth.data() + x),
           .width = vld1q_u16(fused.width.data() + x),
           .source = {},
           .cause = {},
           .seen = vld1q_u16(state.depth.data() + x),
           .known = vandq_u16(tally, all(kMostTally)),
           .votes = vshrq_n_u16(tally, kTallyBits)};
  const Standing is = compare(p, vtstq_u16(changes, changes), limits);
  if (any(is.other)) {
    p.source = load_bytes(fused.source, x);
    p.cause = load_bytes(fused.cause, x);
    advance(row, limits, x, is, p);
    vst1q_u16(fused.depth.data() + x, p.depth);
    vst1q_u16(fused.width.data() + x, p.width);
    store_bytes(fused.source, x, p.source);
    store_bytes(fused.cause, x, p.cause);
  } else {
    advance_alike(is, p);
  }
  vst1q_u16(state.depth.data() + x, p.seen);
  store_bytes(state.tally, x, vorrq_u16(p.known, vshlq_n_u16(p.votes, kTallyBits)));
}

IntervalRow tail(const IntervalRow& row, std::size_t x) noexcept {
  return {row.low.subspan(x), row.high.subspan(x)};
}

}  // namespace

void steady_row(const SteadyRow& row, const SteadyLimits& limits,
                const SteadyState& state) noexcept {
  check_steady_row(row, limits, state);
  std::size_t x = 0;
  for (; x + kLanes <= row.changed.size(); x += kLanes) {
    eight(row, limits, state, x);
  }
  ref::steady_row({.changed = row.changed.subspan(x),
                   .stereo = tail(row.stereo, x),
                   .pmd = tail(row.pmd, x),
                   .fused = {row.fused.depth.subspan(x), row.fused.width.subspan(x),
                             row.fused.source.subspan(x), row.fused.cause.subspan(x)}},
                  limits, {.depth = state.depth.subspan(x), .tally = state.tally.subspan(x)});
}

}  // namespace stof::dsp::neon

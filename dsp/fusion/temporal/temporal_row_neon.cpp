#include "dsp/fusion/temporal/temporal_row.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 16;

// Fields of TemporalState::kind.
constexpr std::uint16_t kSourceMask = 7;
constexpr int kRunShift = 3;
constexpr std::uint16_t kRunMask = 3;
constexpr std::uint16_t kAway = 32;

// Eight pixels, a lane each.
struct Lanes {
  uint16x8_t changed;  // all ones or zeros
  uint16x8_t source;
  uint16x8_t depth;
  uint16x8_t width;
  uint16x8_t tally;
  uint16x8_t kind;
  uint16x8_t mean;
  uint16x8_t scatter;
  uint16x8_t count;  // frames in the mean if it goes on
  int16x8_t over_count;
  int16x8_t over_before;
};

uint16x8_t all(int value) noexcept { return vdupq_n_u16(static_cast<std::uint16_t>(value)); }

uint16x8_t signed_bits(int16x8_t v) noexcept { return vreinterpretq_u16_s16(v); }
int16x8_t as_signed(uint16x8_t v) noexcept { return vreinterpretq_s16_u16(v); }

// half', see temporal_row.h.
uint16x8_t narrowed(uint16x8_t half, uint16x8_t scatter16, uint16x8_t calm) noexcept {
  const uint16x8_t scatter = vshrq_n_u16(scatter16, kMeanBits);
  const uint16x8_t noise = vaddq_u16(vshlq_n_u16(scatter, 1),
                                     vaddq_u16(vshrq_n_u16(scatter, 2), vshrq_n_u16(scatter, 3)));
  const uint16x8_t half_of_it = vshrq_n_u16(half, 1);
  const uint16x8_t loud = vaddq_u16(half, vaddq_u16(half_of_it, vshrq_n_u16(half, 2)));
  const uint16x8_t least = vsubq_u16(half, half_of_it);
  const uint16x8_t narrow = vminq_u16(half, vmaxq_u16(vqsubq_u16(loud, noise), least));
  return vbslq_u16(calm, narrow, half);
}

uint16x8_t limited(uint16x8_t mean, uint16x8_t depth, uint16x8_t reach, uint16x8_t half) noexcept {
  const uint16x8_t least = vmaxq_u16(vqsubq_u16(depth, reach), vminq_u16(depth, half));
  const uint16x8_t most =
      vminq_u16(vqaddq_u16(depth, reach), vmaxq_u16(depth, vsubq_u16(all(kMaxQuarterMm), half)));
  return vminq_u16(vmaxq_u16(mean, least), most);
}

// Writes what becomes of depth, width, mean, scatter, tally and kind.
void advance(const TemporalLimits& limits, Lanes& p) noexcept {
  const uint16x8_t half = vshrq_n_u16(p.width, 1);
  const uint16x8_t half_of_it = vshrq_n_u16(half, 1);
  const uint16x8_t frames = vandq_u16(p.tally, all(kMeanOne - 1));
  const uint16x8_t fraction = vshrq_n_u16(p.tally, kMeanBits);
  const uint16x8_t apart = vabdq_u16(p.depth, p.mean);
  const uint16x8_t away = vcgtq_u16(p.depth, p.mean);
  const uint16x8_t far = vcgtq_u16(apart, vshrq_n_u16(half, 2));
  const uint16x8_t old_run = vandq_u16(vshrq_n_u16(p.kind, kRunShift), all(kRunMask));
  const uint16x8_t turned = veorq_u16(vtstq_u16(p.kind, all(kAway)), away);
  const uint16x8_t run = vandq_u16(far, vaddq_u16(vbicq_u16(old_run, turned), all(1)));

  const uint16x8_t some = vtstq_u16(p.depth, p.depth);
  const uint16x8_t gate = vminq_u16(vaddq_u16(half, half_of_it), all(limits.max_step));
  uint16x8_t keep = vbicq_u16(vandq_u16(some, vtstq_u16(frames, frames)), p.changed);
  keep = vandq_u16(keep, vceqq_u16(vandq_u16(p.kind, all(kSourceMask)), p.source));
  keep = vandq_u16(keep, vandq_u16(vcleq_u16(apart, gate), vcltq_u16(run, all(kRestartRun))));

  // Below 2^15 where the mean goes on: |r| <= kMostStep.
  const int16x8_t r16 =
      as_signed(vsubq_u16(vshlq_n_u16(vsubq_u16(p.depth, p.mean), kMeanBits), fraction));
  const int16x8_t moved = vaddq_s16(as_signed(fraction), simd::scaled_product(r16, p.over_count));
  const uint16x8_t mean = vaddq_u16(p.mean, signed_bits(vshrq_n_s16(moved, kMeanBits)));
  const uint16x8_t rest = vandq_u16(signed_bits(moved), all(kMeanOne - 1));
  const int16x8_t louder = as_signed(vsubq_u16(vshlq_n_u16(apart, kMeanBits), p.scatter));
  const uint16x8_t scatter =
      vaddq_u16(p.scatter, signed_bits(simd::scaled_product(louder, p.over_before)));

  const uint16x8_t calm =
      vandq_u16(vandq_u16(keep, vcgeq_u16(p.count, all(kFramesToNarrow))), vcltq_u16(run, all(2)));
  const uint16x8_t publish = vandq_u16(vandq_u16(keep, vcgeq_u16(p.count, all(kFramesToAverage))),
                                       vcltq_u16(run, all(kRestartRun - 1)));
  const uint16x8_t new_half = narrowed(half, scatter, calm);
  const uint16x8_t rounded = vaddq_u16(mean, vshrq_n_u16(rest, kMeanBits - 1));
  const uint16x8_t out = limited(rounded, p.depth, half_of_it, new_half);

  const uint16x8_t run_bits =
      vorrq_u16(vshlq_n_u16(run, kRunShift), vandq_u16(vandq_u16(far, away), all(kAway)));
  const uint16x8_t begun = vandq_u16(p.source, all(kSourceMask));
  p.kind = vandq_u16(some, vorrq_u16(begun, vandq_u16(keep, run_bits)));
  p.tally =
      vandq_u16(some, vbslq_u16(keep, vorrq_u16(vshlq_n_u16(rest, kMeanBits), p.count), all(1)));
  p.mean = vbslq_u16(keep, mean, p.depth);
  p.scatter = vandq_u16(keep, scatter);
  p.depth = vbslq_u16(publish, out, p.depth);
  p.width = vsubq_u16(p.width, vshlq_n_u16(vsubq_u16(half, new_half), 1));
}

uint8x16_t largest_of_three(std::span<const std::uint8_t> row, std::size_t x) noexcept {
  const std::uint8_t* const at = row.data() + x;
  return vmaxq_u8(vmaxq_u8(vld1q_u8(at), vld1q_u8(at + 1)), vld1q_u8(at + 2));
}

ChangeRows tail(const ChangeRows& change, std::size_t x) noexcept {
  return {change.above.subspan(x), change.here.subspan(x), change.below.subspan(x)};
}

TemporalRow tail(const TemporalRow& row, std::size_t x) noexcept {
  return {row.grey.subspan(x), tail(row.change, x), row.source.subspan(x), row.depth.subspan(x),
          row.width.subspan(x)};
}

TemporalState tail(const TemporalState& state, std::size_t x) noexcept {
  return {state.mean.subspan(x), state.scatter.subspan(x), state.tally.subspan(x),
          state.kind.subspan(x), state.grey.subspan(x)};
}

uint16x8_t wide_low(uint8x16_t v) noexcept { return vmovl_u8(vget_low_u8(v)); }
uint16x8_t wide_high(uint8x16_t v) noexcept { return vmovl_u8(vget_high_u8(v)); }

void store_words(const Lanes& lanes, const TemporalRow& row, const TemporalState& state,
                 std::size_t x) noexcept {
  vst1q_u16(row.depth.data() + x, lanes.depth);
  vst1q_u16(row.width.data() + x, lanes.width);
  vst1q_u16(state.mean.data() + x, lanes.mean);
  vst1q_u16(state.scatter.data() + x, lanes.scatter);
}

void sixteen(const TemporalRow& row, const TemporalLimits& limits, const TemporalState& state,
             std::size_t x) noexcept {
  const uint8x16_t low_table = vld1q_u8(kReciprocals.low.data());
  const uint8x16_t high_table = vld1q_u8(kReciprocals.high.data());
  const uint8x16_t change = vmaxq_u8(
      vmaxq_u8(largest_of_three(row.change.above, x), largest_of_three(row.change.here, x)),
      largest_of_three(row.change.below, x));
  const uint8x16_t changed = vcgtq_u8(change, vdupq_n_u8(limits.max_change));
  const uint8x16_t tally = vld1q_u8(state.tally.data() + x);
  const uint8x16_t kind = vld1q_u8(state.kind.data() + x);
  const uint8x16_t source =
      vld1q_u8(reinterpret_cast<const std::uint8_t*>(row.source.data() + x));  // NOLINT: bytes
  const uint8x16_t before = vandq_u8(tally, vdupq_n_u8(kMeanOne - 1));
  const uint8x16_t count = vminq_u8(vaddq_u8(before, vdupq_n_u8(1)), vdupq_n_u8(limits.frames));
  const uint8x16_t count_low = simd::look_up(low_table, count);
  const uint8x16_t count_high = simd::look_up(high_table, count);
  const uint8x16_t before_low = simd::look_up(low_table, before);
  const uint8x16_t before_high = simd::look_up(high_table, before);

  Lanes first{.changed = vreinterpretq_u16_u8(vzip1q_u8(changed, changed)),
              .source = wide_low(source),
              .depth = vld1q_u16(row.depth.data() + x),
              .width = vld1q_u16(row.width.data() + x),
              .tally = wide_low(tally),
              .kind = wide_low(kind),
              .mean = vld1q_u16(state.mean.data() + x),
              .scatter = vld1q_u16(state.scatter.data() + x),
              .count = wide_low(count),
              .over_count = vreinterpretq_s16_u8(vzip1q_u8(count_low, count_high)),
              .over_before = vreinterpretq_s16_u8(vzip1q_u8(before_low, before_high))};
  Lanes second{.changed = vreinterpretq_u16_u8(vzip2q_u8(changed, changed)),
               .source = wide_high(source),
               .depth = vld1q_u16(row.depth.data() + x + kLanes / 2),
               .width = vld1q_u16(row.width.data() + x + kLanes / 2),
               .tally = wide_high(tally),
               .kind = wide_high(kind),
               .mean = vld1q_u16(state.mean.data() + x + kLanes / 2),
               .scatter = vld1q_u16(state.scatter.data() + x + kLanes / 2),
               .count = wide_high(count),
               .over_count = vreinterpretq_s16_u8(vzip2q_u8(count_low, count_high)),
               .over_before = vreinterpretq_s16_u8(vzip2q_u8(before_low, before_high))};
  advance(limits, first);
  advance(limits, second);
  store_words(first, row, state, x);
  store_words(second, row, state, x + kLanes / 2);

  const uint8x16_t new_tally = vcombine_u8(vmovn_u16(first.tally), vmovn_u16(second.tally));
  const uint8x16_t went_on = vcgtq_u8(vandq_u8(new_tally, vdupq_n_u8(kMeanOne - 1)), vdupq_n_u8(1));
  const uint8x16_t grey =
      vbslq_u8(went_on, vld1q_u8(state.grey.data() + x), vld1q_u8(row.grey.data() + x));
  vst1q_u8(state.tally.data() + x, new_tally);
  vst1q_u8(state.kind.data() + x, vcombine_u8(vmovn_u16(first.kind), vmovn_u16(second.kind)));
  vst1q_u8(state.grey.data() + x, grey);
}

}  // namespace

void grey_change(std::span<const std::uint8_t> now, std::span<const std::uint8_t> then,
                 std::span<std::uint8_t> change) noexcept {
  STOF_CHECK(now.size() == change.size() && then.size() == change.size());
  std::size_t x = 0;
  for (; x + kLanes <= change.size(); x += kLanes) {
    vst1q_u8(change.data() + x, vabdq_u8(vld1q_u8(now.data() + x), vld1q_u8(then.data() + x)));
  }
  ref::grey_change(now.subspan(x), then.subspan(x), change.subspan(x));
}

void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                  const TemporalState& state) noexcept {
  check_temporal_row(row, limits, state);
  std::size_t x = 0;
  for (; x + kLanes <= row.depth.size(); x += kLanes) {
    sixteen(row, limits, state, x);
  }
  ref::temporal_row(tail(row, x), limits, tail(state, x));
}

}  // namespace stof::dsp::neon

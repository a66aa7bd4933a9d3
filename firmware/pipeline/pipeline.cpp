#include "firmware/pipeline/pipeline.h"

#include <algorithm>
#include <chrono>

namespace stof::firmware {
namespace {

constexpr int kFramesBetweenDrifts = 30;

// How many pixels have each value of an enum of bytes, 0 .. counts.size() - 1.
template <typename Value, std::size_t N>
void count_values(dsp::ImageView<const Value> image,
                  std::array<std::uint32_t, N>& counts) noexcept {
  counts.fill(0);
  for (int y = 0; y < image.height(); ++y) {
    const auto row = image.row(y);
    for (std::size_t value = 0; value < N; ++value) {
      counts[value] +=
          static_cast<std::uint32_t>(std::ranges::count(row, static_cast<Value>(value)));
    }
  }
}

dsp::DepthMap take_map(const dsp::Pinhole& left, dsp::Arena& arena) noexcept {
  return {.depth = arena.take_image<dsp::QuarterMm>(left.width, left.height),
          .width = arena.take_image<dsp::QuarterMm>(left.width, left.height),
          .source = arena.take_image<dsp::Source>(left.width, left.height),
          .cause = arena.take_image<dsp::Cause>(left.width, left.height)};
}

std::int32_t whole_us(hal::Duration time) noexcept {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(time).count();
  constexpr std::int64_t kMost = 1'000'000'000;
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(us, -kMost, kMost));
}

// From the middle of the pair's exposure to that of the PMD data in use.
std::int32_t pmd_lag_us(const Shot& shot) noexcept {
  return whole_us(shot.pmd_exposed ? *shot.pmd_exposed - shot.exposed : hal::Duration{});
}

}  // namespace

wire::FrameSizes sizes_of(const Setup& setup) noexcept {
  const dsp::Pinhole& left = setup.calibration.stereo.left;
  const dsp::Pinhole& pmd = setup.calibration.pmd.lens;
  return {
      .width = left.width, .height = left.height, .pmd_width = pmd.width, .pmd_height = pmd.height};
}

Pipeline::Pipeline(const Setup& setup, dsp::Arena& arena, const dsp::ThreadTeam& team) noexcept
    : maker_(setup.calibration, setup.depth, arena, team),
      guided_(setup.depth.guided && setup.has_pmd()) {
  output_.map = take_map(setup.calibration.stereo.left, arena);
}

void Pipeline::match(const hal::StereoFrame& stereo, hal::Clock& clock) noexcept {
  const hal::Time start = clock.now();
  maker_.match(stereo.left, stereo.right);
  output_.stats.match = clock.now() - start;
  matched_ = true;
}

const Output& Pipeline::compute(const Shot& shot, hal::Clock& clock) noexcept {
  Stats& stats = output_.stats;
  const hal::Time start = clock.now();
  if (shot.pmd) {
    const dsp::PmdExposure exposure{.samples = (*shot.pmd)->samples};
    maker_.convert({.first = {&exposure, 1}});
  } else if (!shot.pmd_exposed) {
    maker_.forget_pmd();
  }
  stats.convert = clock.now() - start;
  if (!shot.stereo) {
    maker_.forget_pair();
    stats.match = {};
  } else if (!matched_) {
    match(**shot.stereo, clock);
  }
  matched_ = false;
  if (shot.stereo) {
    since_pair_ = pair_exposed_ ? shot.exposed - *pair_exposed_ : hal::Duration{};
    pair_exposed_ = shot.exposed;
  }
  const hal::Time matched = clock.now();
  maker_.fuse(output_.map, pmd_lag_us(shot));
  stats.fuse = clock.now() - matched;
  output_.steady_frames = maker_.frames();
  output_.stereo = maker_.stereo();
  output_.left = maker_.left();
  output_.right = maker_.right();
  count_values<dsp::Source>(output_.map.source, stats.sources);
  count_values<dsp::Cause>(output_.map.cause, stats.causes);
  return output_;
}

void Pipeline::watch(hal::Clock& clock) noexcept {
  const hal::Time start = clock.now();
  maker_.watch(whole_us(since_pair_));
  if (until_drift_-- == 0) {
    until_drift_ = kFramesBetweenDrifts;
    output_.drift = maker_.drift();
  }
  output_.stats.watch = clock.now() - start;
}

}  // namespace stof::firmware

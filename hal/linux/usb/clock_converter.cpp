#include "hal/linux/usb/clock_converter.h"

#include <algorithm>
#include <chrono>

namespace stof::hal::linux {
namespace {

constexpr Duration kLongestWay = std::chrono::seconds(1);

Duration drift_in(Duration span) noexcept {
  return std::chrono::abs(span) / (1'000'000 / ClockConverter::kDriftPerMillion);
}

}  // namespace

std::optional<Duration> ClockConverter::since(std::uint64_t theirs) const noexcept {
  // Modulo 2^64: right across the wrap.
  const Duration span(static_cast<std::int64_t>(theirs - theirs_));
  if (!known_ || span > kMostSpan || span < -kMostSpan) {
    return std::nullopt;
  }
  return span;
}

void ClockConverter::sync(Time before, std::uint64_t theirs, Time after) noexcept {
  if (after < before || after - before > kLongestWay) {
    return;
  }
  const Time middle = before + (after - before) / 2;
  const Duration new_uncertainty = (after - before + Duration(1)) / 2;
  if (const std::optional<Time> believed = convert(theirs)) {
    const Duration present = *uncertainty(theirs);
    const bool explained = std::chrono::abs(middle - *believed) <= present + new_uncertainty;
    if (explained && present < new_uncertainty) {
      return;
    }
  }
  known_ = true;
  theirs_ = theirs;
  ours_ = middle;
  uncertainty_ = new_uncertainty;
}

std::optional<Time> ClockConverter::convert(std::uint64_t theirs) const noexcept {
  const std::optional<Duration> span = since(theirs);
  return span ? std::optional(ours_ + *span) : std::nullopt;
}

bool ClockConverter::correct_by_event(Time ours, std::uint64_t theirs) noexcept {
  const std::optional<Time> believed = convert(theirs);
  if (!believed) {
    return false;
  }
  const Duration present = *uncertainty(theirs);
  const Duration error = ours - *believed;
  const Duration step = std::clamp(error, -kMostStep, kMostStep);
  theirs_ = theirs;
  ours_ = *believed + step;
  // What is left of an error is uncertainty, and does not hide what was uncertain before.
  uncertainty_ = std::max(kEdgeUncertainty + std::chrono::abs(error - step),
                          step == error ? kEdgeUncertainty : present);
  return true;
}

std::optional<Duration> ClockConverter::uncertainty(std::uint64_t theirs) const noexcept {
  const std::optional<Duration> span = since(theirs);
  return span ? std::optional(uncertainty_ + drift_in(*span)) : std::nullopt;
}

}  // namespace stof::hal::linux

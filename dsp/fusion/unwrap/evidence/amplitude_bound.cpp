#include "dsp/fusion/unwrap/evidence/amplitude_bound.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace stof::dsp {
namespace {

constexpr std::uint32_t kStep = 16;  // 4 mm in quarter mm
constexpr double kMostWhite = 1e6;   // LSB

std::uint64_t square_of(std::uint32_t distance) noexcept {
  const std::uint64_t steps = distance / kStep;
  return steps * steps;
}

// The two bits below the highest, and its place.
std::size_t class_of(std::uint64_t reflectance) noexcept {
  const int width = static_cast<int>(std::bit_width(reflectance | 4U));
  return static_cast<std::size_t>(width * 4) +
         static_cast<std::size_t>((reflectance >> (width - 3)) % 4);
}

std::uint64_t upper_bound_of(std::size_t klass) noexcept {
  return std::uint64_t{4 + klass % 4 + 1} << (klass / 4 - 3);
}

}  // namespace

AmplitudeBound::AmplitudeBound(double white_lsb) noexcept {
  constexpr double kStepsPerMetre = static_cast<double>(kQuarterMmPerMetre) / kStep;
  brightest_ = static_cast<std::uint64_t>(std::llround(
      2 * kMargin * std::min(white_lsb, kMostWhite) * kStepsPerMetre * kStepsPerMetre));
}

void AmplitudeBound::start(const PmdMaps& maps) noexcept {
  range_ = maps.range;
  integration_ = maps.integration;
  learnt_ = 0;
  classes_.fill(0);
}

std::uint32_t AmplitudeBound::amp2(std::uint16_t measured) const noexcept {
  return integration_ == kReferenceIntegration
             ? measured
             : std::uint32_t{measured} * kReferenceIntegration / std::max(integration_, 1U);
}

bool AmplitudeBound::excludes(const Reading& reading, std::uint32_t distance) const noexcept {
  // The amplitude's sigma is the amplitude times 2 pi sigma / range; three of them are 19 / range.
  constexpr std::uint32_t kThreeTurns = 19;
  const std::uint32_t noise = std::min(kThreeTurns * reading.sigma, range_);
  return brightest_ != 0 &&
         std::uint64_t{reading.amp2} * (range_ - noise) * square_of(distance) > brightest_ * range_;
}

void AmplitudeBound::learn(const Reading& reading, std::uint32_t distance) noexcept {
  ++classes_[class_of(reading.amp2 * square_of(distance))];
}

void AmplitudeBound::end_learning() noexcept {
  std::uint64_t all = 0;
  for (const std::uint32_t count : classes_) {
    all += count;
  }
  std::uint64_t brighter = 0;
  for (std::size_t klass = kClasses; klass-- > 0;) {
    brighter += classes_[klass];
    if (brighter * 64 > all) {
      learnt_ = upper_bound_of(klass);
      return;
    }
  }
}

bool AmplitudeBound::outshines(const Reading& reading, std::uint32_t distance) const noexcept {
  return reading.amp2 * square_of(distance) > kUnknownMargin * learnt_;
}

}  // namespace stof::dsp

#include "host/recording/told_lenses.h"

#include <algorithm>

namespace stof::recording {
namespace {

// Settings change the range and the period.
bool same_lens(wire::CalibrationPacket one, const wire::CalibrationPacket& other) {
  one.max_range = other.max_range;
  one.period_ns = other.period_ns;
  return one == other;
}

bool contradicts(const wire::CalibrationPacket& known, const wire::CalibrationPacket& told) {
  if (told.fingerprint == 0) {
    return known.fingerprint != 0 && same_lens(taken_back(known), told);
  }
  return known.fingerprint == told.fingerprint && known.image_width == told.image_width &&
         known.image_height == told.image_height && !same_lens(known, told);
}

}  // namespace

void ToldLenses::take(const wire::CalibrationPacket& calibration) {
  for (const wire::CalibrationPacket& known : known_) {
    contradict_ = contradict_ || contradicts(known, calibration);
  }
  const auto same = [&](const auto& known) { return same_lens(known, calibration); };
  if (known_.size() < kMost && std::ranges::none_of(known_, same)) {
    known_.push_back(calibration);
  }
}

}  // namespace stof::recording

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/wire/messages/calibration.h"

namespace stof::recording {

// The calibrations of a recording, one after the other. Under a fingerprint and an image size no
// sensor tells two lenses: where there are two, somebody else spoke in its name, and nobody can say
// which one is true.
class ToldLenses {
 public:
  void take(const wire::CalibrationPacket& calibration);
  bool contradict() const noexcept { return contradict_; }

 private:
  static constexpr std::size_t kMost = 64;  // a recording has a few

  std::vector<wire::CalibrationPacket> known_;
  bool contradict_ = false;
};

// Whether it is of a frame that names this fingerprint; 0: none named, or told.
constexpr bool of_fingerprint(const wire::CalibrationPacket& calibration,
                              std::uint32_t named) noexcept {
  return named == 0 || calibration.fingerprint == named;
}

// What is recorded where a lens holds no more and no other one is known: the same without a
// fingerprint, which goes with no frame that names one.
constexpr wire::CalibrationPacket taken_back(wire::CalibrationPacket calibration) noexcept {
  calibration.fingerprint = 0;
  return calibration;
}

}  // namespace stof::recording

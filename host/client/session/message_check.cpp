#include "host/client/session/message_check.h"

#include <algorithm>

namespace stof::client {

bool goes_with(const MadeWith& made, const wire::CalibrationPacket& told) noexcept {
  return made.period == Duration(0) ||
         (made.calibration == told.fingerprint && made.period.count() == told.period_ns &&
          made.max_range_um / std::max(told.depth_unit_um, 1U) == told.max_range);
}

MessageCheck::Beside& MessageCheck::at(std::uint32_t number) noexcept {
  Beside& beside = numbers_[number % kNumbers];
  if (beside.number != number) {
    beside = {};
    beside.number = number;
  }
  return beside;
}

bool MessageCheck::take(std::uint32_t number, const wire::CalibrationPacket& told) noexcept {
  Beside& beside = at(number);
  beside.told = told;
  return !beside.made || goes_with(*beside.made, told);
}

bool MessageCheck::take(std::uint32_t number, const MadeWith& made) noexcept {
  Beside& beside = at(number);
  beside.made = made;
  return !beside.told || goes_with(made, *beside.told);
}

}  // namespace stof::client

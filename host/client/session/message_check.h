#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/wire/messages/calibration.h"
#include "host/client/frame/made_with.h"

namespace stof::client {

// Calibration messages against the frames that they were sent beside, whose number they have: file,
// range and period are those that the frame tells of itself, or two have sent them. Of the newest
// 256 numbers; whichever comes first waits for the other one.
class MessageCheck {
 public:
  // False: the frame of this number told something else.
  bool take(std::uint32_t number, const wire::CalibrationPacket& told) noexcept;
  // False: a message of this number did.
  bool take(std::uint32_t number, const MadeWith& made) noexcept;

 private:
  static constexpr std::size_t kNumbers = 256;

  struct Beside {
    std::uint32_t number = 0;
    std::optional<wire::CalibrationPacket> told;
    std::optional<MadeWith> made;
  };

  // Forgets what stood there of another number.
  Beside& at(std::uint32_t number) noexcept;

  std::array<Beside, kNumbers> numbers_{};
};

// Whether a sensor that makes frames so sends this message beside them; one that does not tell
// range and period of a frame may send any.
bool goes_with(const MadeWith& made, const wire::CalibrationPacket& told) noexcept;

}  // namespace stof::client

#pragma once

#include <cstdint>
#include <expected>

namespace stof {

// Outcomes at run time. Every function that returns one says which of these it may return.
enum class [[nodiscard]] Status : std::uint8_t {
  kOk,
  kTimeout,          // the deadline passed; try again at the next edge
  kWouldBlock,       // the device's queue is full; the item was not taken
  kCorrupt,          // the data arrived damaged or incomplete and was dropped
  kDeviceLost,       // the device is gone; reopen it
  kDeviceError,      // the device answered with an error; it may work again
  kInvalidArgument,  // the caller's value is out of range
  kTooLarge,         // the data does not fit the space that was reserved for it
  kUnsupported,      // valid, but not something this build or version can do
};

// A name for messages, such as "timeout". Never empty.
const char* to_string(Status status) noexcept;

template <typename T>
using Result = std::expected<T, Status>;

// return fail(Status::kTimeout);
constexpr std::unexpected<Status> fail(Status status) noexcept {
  return std::unexpected<Status>(status);
}

}  // namespace stof

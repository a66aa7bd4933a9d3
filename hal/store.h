#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dsp/base/status.h"

namespace stof::hal {

// One small document that outlives a power cut. For one thread; allocates nothing. May block for as
// long as the medium takes, seconds on a worn one.
class Store {
 public:
  virtual ~Store() = default;

  // Loads what was saved last. Returns its bytes; none: nothing was saved. kTooLarge: more than
  // `space`. kDeviceError: it cannot be read. kUnsupported: what is in its place is no document: it
  // is not opened.
  virtual Result<std::optional<std::size_t>> load(std::span<std::byte> space) noexcept = 0;
  // After kOk, load() returns these bytes; until then the previous ones. A power cut never leaves a
  // mixture. kDeviceError: the medium does not take them, or what is there cannot be read; the
  // previous ones stay. kUnsupported: as load().
  virtual Status save(std::span<const std::byte> bytes) noexcept = 0;
  // Keeps the document for somebody to look at, but loads it no more. kDeviceError, kUnsupported:
  // it stays.
  virtual Status set_aside() noexcept = 0;
};

}  // namespace stof::hal

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"

namespace stof::hal {

// A serial line, 8N1. For one thread; nothing blocks, nothing allocates.
class SerialPort {
 public:
  virtual ~SerialPort() = default;

  // Takes the first bytes, as many as its queue has room for, perhaps none: how many.
  // kDeviceLost: reopen.
  virtual Result<std::size_t> write(std::span<const std::byte> bytes) noexcept = 0;
  // Reads what has arrived, perhaps nothing: how many bytes. kDeviceLost: reopen.
  virtual Result<std::size_t> read(std::span<std::byte> space) noexcept = 0;
  // From now on. kUnsupported: the line cannot do it; it stays as it was. kDeviceLost.
  virtual Status set_baud(std::uint32_t baud) noexcept = 0;
  // Opens it again, in place; may block for up to a second. kDeviceLost: not back yet.
  virtual Status reopen() noexcept = 0;
};

}  // namespace stof::hal

#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <utility>

#include "hal/serial_port.h"
#include "posix/fd.h"

namespace stof::hal::linux {

struct SerialOptions {
  std::string device;  // such as /dev/ttyAMA0
  std::uint32_t baud = 921'600;
  bool flow_control = false;  // RTS and CTS
};

// A tty as a raw 8N1 line: any baud the driver makes within 3 percent, exclusive, no controlling
// terminal, no waiting for a carrier. A pseudo-terminal is one as well.
class SerialTty final : public SerialPort {
 public:
  static constexpr std::uint32_t kLeastBaud = 57'600;
  static constexpr std::uint32_t kMostBaud = 12'000'000;

  // Does not wait for anything. An error is one line: what, why and what to do.
  static std::expected<SerialTty, std::string> open(const SerialOptions& options);
  // As one that is lost: reopen() opens it.
  static SerialTty closed(const SerialOptions& options) { return SerialTty(options); }

  SerialTty(SerialTty&&) noexcept = default;
  SerialTty& operator=(SerialTty&& other) noexcept {
    std::swap(options_, other.options_);
    std::swap(line_, other.line_);  // the old line closes with `other`
    return *this;
  }
  SerialTty(const SerialTty&) = delete;
  SerialTty& operator=(const SerialTty&) = delete;
  ~SerialTty() override;

  Result<std::size_t> write(std::span<const std::byte> bytes) noexcept override;
  Result<std::size_t> read(std::span<std::byte> space) noexcept override;
  // kUnsupported also outside of kLeastBaud to kMostBaud.
  Status set_baud(std::uint32_t baud) noexcept override;
  Status reopen() noexcept override;

 private:
  explicit SerialTty(SerialOptions options) : options_(std::move(options)) {}
  int open_line() noexcept;  // 0 or an errno
  void shut() noexcept;

  SerialOptions options_;
  posix::Fd line_;
};

}  // namespace stof::hal::linux

#include "hal/linux/ports/serial_tty.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <unistd.h>

#include "posix/terminal.h"

namespace stof::hal::linux {
namespace {

bool takes(std::uint32_t baud) noexcept {
  return baud >= SerialTty::kLeastBaud && baud <= SerialTty::kMostBaud;
}

const char* advice(int error) noexcept {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return "check the cable and the device's name";
    case EACCES:
    case EPERM:
      return "add the user to the group of that device, often dialout";
    case EBUSY:
      return "another program has it: end that first";
    case ENOTTY:
      return "give the name of a serial line, such as /dev/ttyAMA0";
    case EINVAL:
      return "the line does not make that speed: choose another one";
    default:
      return "check the cable";
  }
}

}  // namespace

std::expected<SerialTty, std::string> SerialTty::open(const SerialOptions& options) {
  std::string message = "cannot open serial line '" + options.device + "' at " +
                        std::to_string(options.baud) + " baud: ";
  if (!takes(options.baud)) {
    return std::unexpected(message.append("give 57600 to 12000000 baud"));
  }
  SerialTty tty(options);
  if (const int error = tty.open_line(); error != 0) {
    return std::unexpected(message.append(std::strerror(error)).append("; ").append(advice(error)));
  }
  return tty;
}

SerialTty::~SerialTty() { shut(); }

void SerialTty::shut() noexcept {
  if (line_.is_open()) {
    posix::discard_buffers(line_.get());
    posix::end_exclusive(line_.get());
    line_.reset();
  }
}

int SerialTty::open_line() noexcept {
  shut();
  std::expected<posix::Fd, int> line = posix::open_line(options_.device.c_str());
  int error = line ? posix::make_exclusive(line->get()) : line.error();
  if (error == 0) {
    error = posix::make_raw(line->get(), {options_.baud, options_.flow_control});
  }
  if (error == 0) {
    line_ = *std::move(line);
  }
  return error;
}

Status SerialTty::reopen() noexcept { return open_line() == 0 ? Status::kOk : Status::kDeviceLost; }

Result<std::size_t> SerialTty::write(std::span<const std::byte> bytes) noexcept {
  if (bytes.empty()) {
    return std::size_t{0};
  }
  for (;;) {
    const ssize_t count = ::write(line_.get(), bytes.data(), bytes.size());
    if (count >= 0) {
      return static_cast<std::size_t>(count);
    }
    if (errno == EAGAIN) {
      return std::size_t{0};
    }
    if (errno != EINTR) {
      return fail(Status::kDeviceLost);
    }
  }
}

Result<std::size_t> SerialTty::read(std::span<std::byte> space) noexcept {
  if (space.empty()) {
    return std::size_t{0};
  }
  for (;;) {
    const ssize_t count = ::read(line_.get(), space.data(), space.size());
    if (count > 0) {
      return static_cast<std::size_t>(count);
    }
    if (count < 0 && errno == EAGAIN) {
      return std::size_t{0};
    }
    if (count == 0 || errno != EINTR) {
      return fail(Status::kDeviceLost);
    }
  }
}

Status SerialTty::set_baud(std::uint32_t baud) noexcept {
  if (!takes(baud)) {
    return Status::kUnsupported;
  }
  const int error = posix::make_raw(line_.get(), {baud, options_.flow_control});
  if (error == 0) {
    options_.baud = baud;
    return Status::kOk;
  }
  if (error != EINVAL ||
      posix::make_raw(line_.get(), {options_.baud, options_.flow_control}) != 0) {
    return Status::kDeviceLost;
  }
  return Status::kUnsupported;
}

}  // namespace stof::hal::linux

#include "hal/linux/ports/serial_tty.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

// Of the kernel and not <termios.h>, which has no speeds but the old ones; the two exclude each
// other.
#include <asm/termbits.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace stof::hal::linux {
namespace {

struct NamedSpeed {
  std::uint32_t baud;
  tcflag_t flag;
};
// For drivers, and emulated kernels, that take no other.
constexpr std::array kNamedSpeeds{NamedSpeed{57'600, B57600},      NamedSpeed{115'200, B115200},
                                  NamedSpeed{230'400, B230400},    NamedSpeed{460'800, B460800},
                                  NamedSpeed{500'000, B500000},    NamedSpeed{576'000, B576000},
                                  NamedSpeed{921'600, B921600},    NamedSpeed{1'000'000, B1000000},
                                  NamedSpeed{1'152'000, B1152000}, NamedSpeed{1'500'000, B1500000},
                                  NamedSpeed{2'000'000, B2000000}, NamedSpeed{2'500'000, B2500000},
                                  NamedSpeed{3'000'000, B3000000}, NamedSpeed{3'500'000, B3500000},
                                  NamedSpeed{4'000'000, B4000000}};

template <typename Termios>
void make_raw(Termios& line, bool flow_control) noexcept {
  line.c_iflag = IGNBRK | IGNPAR;
  line.c_oflag = 0;
  line.c_lflag = 0;
  line.c_cflag = CS8 | CREAD | CLOCAL | (flow_control ? CRTSCTS : 0U);
  std::memset(line.c_cc, 0, sizeof line.c_cc);
  line.c_cc[VMIN] = 1;  // so that 0 bytes mean the end of the line and not patience
}

// The kernel's answer may be another speed than asked for: what the divider makes of it.
bool near_enough(std::uint32_t asked, std::uint32_t got) noexcept {
  const std::uint32_t difference = asked > got ? asked - got : got - asked;
  return std::uint64_t{difference} * 100 <= std::uint64_t{asked} * 3;
}

// Zero or the error.
int configure_any(int fd, const SerialOptions& options) noexcept {
  termios2 line{};
  if (ioctl(fd, TCGETS2, &line) != 0) {
    return errno;
  }
  make_raw(line, options.flow_control);
  line.c_cflag |= BOTHER | (static_cast<tcflag_t>(BOTHER) << IBSHIFT);
  line.c_ispeed = options.baud;
  line.c_ospeed = options.baud;
  if (ioctl(fd, TCSETS2, &line) != 0 || ioctl(fd, TCGETS2, &line) != 0) {
    return errno;
  }
  return near_enough(options.baud, line.c_ospeed) ? 0 : EINVAL;
}

int configure_named(int fd, const SerialOptions& options) noexcept {
  for (const NamedSpeed& speed : kNamedSpeeds) {
    if (speed.baud != options.baud) {
      continue;
    }
    termios line{};
    if (ioctl(fd, TCGETS, &line) != 0) {
      return errno;
    }
    make_raw(line, options.flow_control);
    line.c_cflag |= speed.flag;
    return ioctl(fd, TCSETS, &line) == 0 ? 0 : errno;
  }
  return EINVAL;
}

int configure(int fd, const SerialOptions& options) noexcept {
  const int error = configure_any(fd, options);
  return error == EINVAL || error == ENOSYS ? configure_named(fd, options) : error;
}

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
  errno = 0;
  if (tty.reopen() != Status::kOk) {
    const int error = errno;
    return std::unexpected(message.append(std::strerror(error)).append("; ").append(advice(error)));
  }
  return tty;
}

SerialTty::SerialTty(SerialTty&& other) noexcept
    : options_(std::move(other.options_)), fd_(std::exchange(other.fd_, -1)) {}

SerialTty& SerialTty::operator=(SerialTty&& other) noexcept {
  std::swap(options_, other.options_);
  std::swap(fd_, other.fd_);  // the old line closes with `other`
  return *this;
}

SerialTty::~SerialTty() { shut(); }

void SerialTty::shut() noexcept {
  if (fd_ >= 0) {
    // What waits would hold up close() until a silent peer takes it.
    static_cast<void>(ioctl(fd_, TCFLSH, TCIOFLUSH));
    close(fd_);
    fd_ = -1;
  }
}

Status SerialTty::reopen() noexcept {
  shut();
  const int fd = ::open(options_.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    return Status::kDeviceLost;
  }
  int error = ioctl(fd, TIOCEXCL) == 0 ? 0 : errno;
  if (error == 0) {
    error = configure(fd, options_);
  }
  if (error != 0) {
    close(fd);
    errno = error;
    return Status::kDeviceLost;
  }
  fd_ = fd;
  return Status::kOk;
}

Result<std::size_t> SerialTty::write(std::span<const std::byte> bytes) noexcept {
  if (bytes.empty()) {
    return std::size_t{0};
  }
  for (;;) {
    const ssize_t count = ::write(fd_, bytes.data(), bytes.size());
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
    const ssize_t count = ::read(fd_, space.data(), space.size());
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
  const SerialOptions wanted{.device = {}, .baud = baud, .flow_control = options_.flow_control};
  const int error = configure(fd_, wanted);
  if (error == 0) {
    options_.baud = baud;
    return Status::kOk;
  }
  if (error != EINVAL || configure(fd_, options_) != 0) {
    return Status::kDeviceLost;
  }
  return Status::kUnsupported;
}

}  // namespace stof::hal::linux

#include "posix/terminal.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

// Of the kernel and not <termios.h>, which has no speeds but the old ones; the two exclude each
// other.
#include <asm/termbits.h>
#include <fcntl.h>
#include <sys/ioctl.h>

namespace stof::posix {
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
void set_raw(Termios& line, bool flow_control) noexcept {
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

int set_any_speed(int fd, const LineSettings& settings) noexcept {
  termios2 line{};
  if (ioctl(fd, TCGETS2, &line) != 0) {
    return errno;
  }
  set_raw(line, settings.flow_control);
  line.c_cflag |= BOTHER | (static_cast<tcflag_t>(BOTHER) << IBSHIFT);
  line.c_ispeed = settings.baud;
  line.c_ospeed = settings.baud;
  if (ioctl(fd, TCSETS2, &line) != 0 || ioctl(fd, TCGETS2, &line) != 0) {
    return errno;
  }
  return near_enough(settings.baud, line.c_ospeed) ? 0 : EINVAL;
}

int set_named_speed(int fd, const LineSettings& settings) noexcept {
  for (const NamedSpeed& speed : kNamedSpeeds) {
    if (speed.baud != settings.baud) {
      continue;
    }
    termios line{};
    if (ioctl(fd, TCGETS, &line) != 0) {
      return errno;
    }
    set_raw(line, settings.flow_control);
    line.c_cflag |= speed.flag;
    return ioctl(fd, TCSETS, &line) == 0 ? 0 : errno;
  }
  return EINVAL;
}

}  // namespace

std::expected<Fd, int> open_line(const char* device) noexcept {
  Fd fd(open(device, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd.is_open()) {
    return std::unexpected(errno);
  }
  return fd;
}

int make_raw(int fd, const LineSettings& settings) noexcept {
  const int error = set_any_speed(fd, settings);
  return error == EINVAL || error == ENOSYS ? set_named_speed(fd, settings) : error;
}

int make_exclusive(int fd) noexcept { return ioctl(fd, TIOCEXCL) == 0 ? 0 : errno; }

void end_exclusive(int fd) noexcept { static_cast<void>(ioctl(fd, TIOCNXCL)); }

void discard_buffers(int fd) noexcept { static_cast<void>(ioctl(fd, TCFLSH, TCIOFLUSH)); }

bool has_any_speed(int fd) noexcept {
  termios2 line{};
  return ioctl(fd, TCGETS2, &line) == 0;
}

bool has_flow_control(int fd) noexcept {
  termios line{};
  return ioctl(fd, TCGETS, &line) == 0 && (line.c_cflag & CRTSCTS) != 0;
}

std::expected<Fd, int> open_pseudo_terminal(std::string& name) {
  Fd fd(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  std::array<char, 64> device{};
  if (!fd.is_open() || grantpt(fd.get()) != 0 || unlockpt(fd.get()) != 0 ||
      ptsname_r(fd.get(), device.data(), device.size()) != 0) {
    return std::unexpected(errno);
  }
  name = device.data();
  return fd;
}

}  // namespace stof::posix

#include "host/cli/serial_transport.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include <asm/termbits.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "firmware/wire/packet.h"
#include "hal/framing/cobs.h"

namespace stof::host {
namespace {

using client::Duration;
using Steady = std::chrono::steady_clock;

constexpr Duration kSendTime = std::chrono::seconds(1);

class SerialTransport final : public client::ControlTransport {
 public:
  SerialTransport(int fd, std::string device) : fd_(fd), device_(std::move(device)) {}
  ~SerialTransport() override { ::close(fd_); }
  SerialTransport(const SerialTransport&) = delete;
  SerialTransport& operator=(const SerialTransport&) = delete;

  Status send(std::span<const std::byte> packet) override {
    // A zero before it ends whatever noise stands before.
    std::array<std::byte, hal::cobs_bound(wire::kMaxDatagram) + 2> space{};
    if (packet.size() > wire::kMaxDatagram) {
      return Status::kTooLarge;
    }
    const std::size_t bytes = 1 + hal::cobs_encode(packet, std::span(space).subspan(1)) + 1;
    return write_all(std::span(space).first(bytes));
  }

  Result<std::vector<std::byte>> receive(Duration timeout) override {
    const Steady::time_point deadline = Steady::now() + timeout;
    while (true) {
      if (const auto frame = reader_.take(unread_)) {
        return std::vector<std::byte>(frame->begin(), frame->end());
      }
      if (const Status status = wait(POLLIN, deadline); status != Status::kOk) {
        return fail(status);
      }
      const ssize_t got = ::read(fd_, space_.data(), space_.size());
      if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) {
        return fail(Status::kDeviceLost);
      }
      unread_ = std::span(space_).first(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    }
  }

  std::string place() const override { return device_; }

 private:
  Status wait(short events, Steady::time_point deadline) const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Steady::now());
    if (left.count() <= 0) {
      return Status::kTimeout;
    }
    pollfd asked{.fd = fd_, .events = events, .revents = 0};
    const int ready = ::poll(&asked, 1, static_cast<int>(left.count()));
    if (ready < 0) {
      return errno == EINTR ? Status::kOk : Status::kDeviceLost;
    }
    if (ready == 0) {
      return Status::kTimeout;
    }
    return (asked.revents & events) != 0 ? Status::kOk : Status::kDeviceLost;
  }

  Status write_all(std::span<const std::byte> bytes) {
    const Steady::time_point deadline = Steady::now() + kSendTime;
    while (!bytes.empty()) {
      const ssize_t taken = ::write(fd_, bytes.data(), bytes.size());
      if (taken > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(taken));
      } else if (taken < 0 && errno != EAGAIN && errno != EINTR) {
        return Status::kDeviceLost;
      } else if (const Status status = wait(POLLOUT, deadline); status != Status::kOk) {
        return status == Status::kTimeout ? Status::kDeviceError : status;
      }
    }
    return Status::kOk;
  }

  int fd_;
  std::string device_;
  hal::CobsReader reader_;
  std::array<std::byte, 4096> space_{};
  std::span<const std::byte> unread_;  // of space_
};

// false: errno says why.
bool make_raw(int fd, unsigned baud) {
  termios2 line{};
  if (::ioctl(fd, TCGETS2, &line) != 0) {
    return false;
  }
  line.c_iflag = 0;
  line.c_oflag = 0;
  line.c_lflag = 0;
  line.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
  line.c_ispeed = baud;
  line.c_ospeed = baud;
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  return ::ioctl(fd, TCSETS2, &line) == 0 && ::ioctl(fd, TCFLSH, TCIOFLUSH) == 0;
}

}  // namespace

std::expected<std::unique_ptr<client::ControlTransport>, client::ControlError>
open_serial_transport(const std::string& device, unsigned baud) {
  const int fd = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0 || !make_raw(fd, baud)) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) {
      ::close(fd);
    }
    return std::unexpected(client::ControlError{
        Status::kDeviceError,
        device + ": " + why +
            ": give a serial line that exists and may be opened, such as /dev/ttyUSB0"});
  }
  return std::make_unique<SerialTransport>(fd, device);
}

}  // namespace stof::host

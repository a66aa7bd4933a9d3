#include "host/cli/serial_transport.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include <unistd.h>

#include "firmware/wire/packet.h"
#include "hal/framing/cobs.h"
#include "posix/poll.h"
#include "posix/terminal.h"

namespace stof::host {
namespace {

using client::Duration;
using Steady = std::chrono::steady_clock;

constexpr Duration kSendTime = std::chrono::seconds(1);

class SerialTransport final : public client::ControlTransport {
 public:
  SerialTransport(posix::Fd line, std::string device)
      : line_(std::move(line)), device_(std::move(device)) {}

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
      const ssize_t got = ::read(line_.get(), space_.data(), space_.size());
      if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) {
        return fail(Status::kDeviceLost);
      }
      unread_ = std::span(space_).first(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    }
  }

  std::string place() const override { return device_; }

 private:
  Status wait(short events, Steady::time_point deadline) const {
    std::array entries{pollfd{.fd = line_.get(), .events = events, .revents = 0}};
    while (Steady::now() < deadline) {
      const auto ready = posix::wait_for(entries, deadline - Steady::now());
      if (!ready || *ready > 0) {
        return ready && (entries[0].revents & events) != 0 ? Status::kOk : Status::kDeviceLost;
      }
    }
    return Status::kTimeout;
  }

  Status write_all(std::span<const std::byte> bytes) {
    const Steady::time_point deadline = Steady::now() + kSendTime;
    while (!bytes.empty()) {
      const ssize_t taken = ::write(line_.get(), bytes.data(), bytes.size());
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

  posix::Fd line_;
  std::string device_;
  hal::CobsReader reader_;
  std::array<std::byte, 4096> space_{};
  std::span<const std::byte> unread_;  // of space_
};

}  // namespace

std::expected<std::unique_ptr<client::ControlTransport>, client::ControlError>
open_serial_transport(const std::string& device, unsigned baud) {
  auto line = posix::open_line(device.c_str());
  const int error = line ? posix::make_raw(line->get(), {.baud = baud}) : line.error();
  if (error != 0) {
    return std::unexpected(client::ControlError{
        Status::kDeviceError,
        device + ": " + std::strerror(error) +
            ": give a serial line that exists and may be opened, such as /dev/ttyUSB0"});
  }
  posix::discard_buffers(line->get());
  return std::make_unique<SerialTransport>(*std::move(line), device);
}

}  // namespace stof::host

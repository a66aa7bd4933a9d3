#include "host/client/serial/serial_line.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <unistd.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/packet.h"
#include "posix/poll.h"
#include "posix/terminal.h"

namespace stof::client {
namespace {

constexpr Duration kSendTime = std::chrono::seconds(1);
// The other one may have read what is waited for.
constexpr Duration kLook = std::chrono::milliseconds(20);

// By the type alone: whoever gets it judges the rest.
SerialLine::For reader_of(std::span<const std::byte> packet) noexcept {
  constexpr std::size_t kTypeAt = 5;
  if (packet.size() <= kTypeAt) {
    return SerialLine::For::kAsker;
  }
  switch (static_cast<wire::PacketType>(packet[kTypeAt])) {
    case wire::PacketType::kTile:
    case wire::PacketType::kFrameInfo:
    case wire::PacketType::kCalibration:
    case wire::PacketType::kHealth:
    case wire::PacketType::kParity:
    case wire::PacketType::kEvent:
    case wire::PacketType::kSectors:
      return SerialLine::For::kReceiver;
    default:
      return SerialLine::For::kAsker;
  }
}

class SerialTransport final : public ControlTransport {
 public:
  explicit SerialTransport(std::shared_ptr<SerialLine> line) : line_(std::move(line)) {}

  Status send(std::span<const std::byte> packet) override { return line_->send(packet); }
  Result<std::vector<std::byte>> receive(Duration timeout) override {
    Result<SerialLine::Packet> packet = line_->take(SerialLine::For::kAsker, timeout);
    if (!packet) {
      return fail(packet.error());
    }
    return std::move(packet->bytes);
  }
  std::string place() const override { return line_->device(); }
  Reach reach() const override { return Reach::kLine; }

 private:
  std::shared_ptr<SerialLine> line_;
};

}  // namespace

std::expected<std::shared_ptr<SerialLine>, OpenError> SerialLine::open(const std::string& device,
                                                                       unsigned baud) {
  auto line = posix::open_line(device.c_str());
  const int error = line ? posix::make_raw(line->get(), {.baud = baud}) : line.error();
  if (error != 0) {
    return std::unexpected(
        OpenError{Status::kDeviceError,
                  device + ": " + std::strerror(error) +
                      ": give a serial line that exists and may be opened, such as /dev/ttyUSB0"});
  }
  posix::discard_buffers(line->get());
  return std::shared_ptr<SerialLine>(new SerialLine(*std::move(line), device));
}

Status SerialLine::send(std::span<const std::byte> packet) {
  if (packet.size() > wire::kMaxDatagram) {
    return Status::kTooLarge;
  }
  // A zero before it ends whatever noise stands before.
  std::array<std::byte, hal::cobs_bound(wire::kMaxDatagram) + 2> space{};
  std::span<const std::byte> bytes =
      std::span(space).first(1 + hal::cobs_encode(packet, std::span(space).subspan(1)) + 1);
  const std::scoped_lock lock(sending_);
  const Time deadline = Time::clock::now() + kSendTime;
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

Result<SerialLine::Packet> SerialLine::take(For whom, Duration timeout) {
  const Time begin = Time::clock::now();
  const Time deadline = timeout > Time::max() - begin ? Time::max() : begin + timeout;
  while (true) {
    {
      const std::scoped_lock lock(mutex_);
      std::deque<Packet>& mine = queue(whom);
      if (mine.empty()) {
        if (const Status status = read(); status != Status::kOk) {
          return fail(status);
        }
      }
      if (!mine.empty()) {
        Packet packet = std::move(mine.front());
        mine.pop_front();
        return packet;
      }
    }
    const Time now = Time::clock::now();
    if (now >= deadline) {
      return fail(Status::kTimeout);
    }
    const Time until = now + std::min<Duration>(kLook, deadline - now);
    if (wait(POLLIN, until) == Status::kDeviceLost) {
      return fail(Status::kDeviceLost);
    }
  }
}

bool SerialLine::holds(For whom) const {
  const std::scoped_lock lock(mutex_);
  return !waiting_[static_cast<std::size_t>(whom)].empty();
}

std::uint64_t SerialLine::dropped() const {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

// All that is there.
Status SerialLine::read() {
  const ssize_t got = ::read(line_.get(), space_.data(), space_.size());
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) {
    return Status::kDeviceLost;
  }
  const Time now = Time::clock::now();
  std::span<const std::byte> bytes =
      std::span(space_).first(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  while (const auto frame = reader_.take(bytes)) {
    const For whom = reader_of(*frame);
    if (whom == For::kReceiver && !receives_) {
      continue;
    }
    std::deque<Packet>& to = queue(whom);
    if (to.size() >= kMostWaiting) {
      to.pop_front();
      dropped_ += whom == For::kReceiver ? 1U : 0U;
    }
    to.push_back({.bytes = {frame->begin(), frame->end()}, .arrived = now});
  }
  return Status::kOk;
}

Status SerialLine::wait(short events, Time deadline) const {
  std::array entries{pollfd{.fd = line_.get(), .events = events, .revents = 0}};
  while (Time::clock::now() < deadline) {
    const auto ready = posix::wait_for(entries, deadline - Time::clock::now());
    if (!ready || *ready > 0) {
      return ready && (entries[0].revents & events) != 0 ? Status::kOk : Status::kDeviceLost;
    }
  }
  return Status::kTimeout;
}

std::unique_ptr<ControlTransport> serial_transport(std::shared_ptr<SerialLine> line) {
  return std::make_unique<SerialTransport>(std::move(line));
}

std::expected<std::unique_ptr<ControlTransport>, ControlError> open_serial_transport(
    const std::string& device, unsigned baud) {
  auto line = SerialLine::open(device, baud);
  if (!line) {
    return std::unexpected(std::move(line.error()));
  }
  return serial_transport(*std::move(line));
}

}  // namespace stof::client

#include "host/client/receiver.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "host/client/udp_socket.h"

namespace stof::client {
namespace {

constexpr Duration kForever = std::chrono::hours(24 * 365);  // keeps sums of times in range

}  // namespace

struct Receiver::Parts {
  Parts(std::unique_ptr<UdpSocket> bound, const ReceiverOptions& options)
      : socket(std::move(bound)),
        reassembler(options.reassembler),
        asked_buffer(options.socket_buffer) {}

  // Pushes what was read until a frame is finished.
  std::optional<Frame> push_read() {
    std::optional<Frame> frame = reassembler.take();
    const Time now = std::chrono::steady_clock::now();
    while (!frame && next < read) {
      reassembler.push(socket->datagram(next++), now);
      frame = reassembler.take();
    }
    return frame;
  }

  std::unique_ptr<UdpSocket> socket;
  Reassembler reassembler;
  int asked_buffer;
  std::size_t read = 0;  // datagrams in the socket's space
  std::size_t next = 0;  // of these, to push
  mutable Statistics statistics;
};

std::expected<Receiver, OpenError> Receiver::open(const ReceiverOptions& options) {
  auto socket = UdpSocket::open(options.address, options.port, options.socket_buffer);
  if (!socket) {
    return std::unexpected(OpenError{socket.error().status, std::move(socket.error().message)});
  }
  return Receiver(std::make_unique<Parts>(std::move(*socket), options));
}

Receiver::Receiver(std::unique_ptr<Parts> parts) noexcept : parts_(std::move(parts)) {}
Receiver::Receiver(Receiver&&) noexcept = default;
Receiver& Receiver::operator=(Receiver&&) noexcept = default;
Receiver::~Receiver() = default;

Result<Frame> Receiver::next(Duration timeout) {
  const Time deadline = std::chrono::steady_clock::now() + std::min(timeout, kForever);
  while (true) {
    if (const std::optional<Frame> frame = parts_->push_read()) {
      return *frame;
    }
    const Result<std::size_t> read = parts_->socket->receive();
    if (!read) {
      return fail(read.error());
    }
    parts_->read = *read;
    parts_->next = 0;
    if (*read > 0) {
      continue;
    }
    // Only now: while the socket held packets, no frame was known to wait in vain.
    const Time now = std::chrono::steady_clock::now();
    parts_->reassembler.expire(now);
    if (const std::optional<Frame> frame = parts_->reassembler.take()) {
      return *frame;
    }
    if (now >= deadline) {
      return fail(Status::kTimeout);
    }
    const Time until = std::min(deadline, parts_->reassembler.next_expiry().value_or(deadline));
    if (parts_->socket->wait(until - now) == Status::kDeviceLost) {
      return fail(Status::kDeviceLost);
    }
  }
}

const Statistics& Receiver::statistics() const noexcept {
  parts_->statistics = parts_->reassembler.statistics();
  parts_->statistics.socket_drops = parts_->socket->dropped();
  return parts_->statistics;
}

std::uint16_t Receiver::port() const noexcept { return parts_->socket->port(); }

int Receiver::socket_buffer() const noexcept { return parts_->socket->buffer_bytes(); }

std::string Receiver::advice() const {
  if (socket_buffer() >= parts_->asked_buffer) {
    return "";
  }
  return "socket buffer: " + std::to_string(socket_buffer()) + " bytes instead of " +
         std::to_string(parts_->asked_buffer) +
         ", bursts of packets may be lost; allow more with: sysctl -w net.core.rmem_max=" +
         std::to_string(parts_->asked_buffer);
}

}  // namespace stof::client

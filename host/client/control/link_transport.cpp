#include "host/client/control/link_transport.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "firmware/wire/packet.h"
#include "posix/interfaces.h"
#include "posix/poll.h"
#include "posix/udp_socket.h"

namespace stof::client {
namespace {

using wire::PacketType;

// Over a link only a discover may go to any sensor. What is signed names its own.
std::span<const std::byte> addressed(std::span<const std::byte> packet, std::uint32_t device_id,
                                     wire::DatagramBuffer& buffer) {
  const auto parsed = wire::parse_packet(packet);
  if (!parsed || parsed->header.origin.device_id != 0 ||
      parsed->header.type == PacketType::kSignedRequest) {
    return packet;
  }
  wire::Header header = parsed->header;
  header.origin.device_id = device_id;
  std::ranges::copy(parsed->payload, wire::payload_space(buffer).begin());
  return wire::seal_packet(header, parsed->payload.size(), buffer);
}

class LinkTransport final : public ControlTransport {
 public:
  LinkTransport(posix::UdpSocket socket, LinkTarget target)
      : socket_(std::move(socket)), target_(std::move(target)) {}

  Status send(std::span<const std::byte> packet) override {
    wire::DatagramBuffer buffer;
    const std::span<const std::byte> datagram = addressed(packet, target_.device_id, buffer);
    const posix::SocketAddress all =
        posix::make_address(in_addr{.s_addr = INADDR_BROADCAST}, target_.port);
    Status status = Status::kDeviceError;
    for (const unsigned interface : posix::list_interfaces().links) {
      if (socket_.send_by(interface, all, datagram) == 0) {
        status = Status::kOk;
      }
    }
    return status;
  }

  Result<std::vector<std::byte>> receive(Duration timeout) override {
    const Time deadline = Time::clock::now() + timeout;
    std::array<std::byte, wire::kMaxDatagram + 1> space{};
    for (;;) {
      const auto got = socket_.receive(space, &from_);
      if (got && is_answer(std::span(space).first(*got))) {
        return std::vector<std::byte>(space.begin(),
                                      space.begin() + static_cast<std::ptrdiff_t>(*got));
      }
      const Duration left = deadline - Time::clock::now();
      if (left <= Duration::zero()) {
        return fail(Status::kTimeout);
      }
      std::array entries{pollfd{.fd = socket_.fd(), .events = POLLIN, .revents = 0}};
      if (!got && !posix::wait_for(entries, left)) {
        return fail(Status::kDeviceLost);
      }
    }
  }

  std::string place() const override { return target_.called + ", by broadcast"; }
  std::string from() const override { return from_.host(); }
  Reach reach() const override { return Reach::kLink; }

 private:
  // Everybody near tells the same port who he is, and hears what others are answered.
  bool is_answer(std::span<const std::byte> datagram) const {
    const auto packet = wire::parse_packet(datagram);
    if (!packet || packet->header.origin.device_id != target_.device_id ||
        packet->header.origin.session_id != target_.session_id) {
      return false;
    }
    const PacketType type = packet->header.type;
    return type == PacketType::kSettingsAnswer || type == PacketType::kSignedAnswer ||
           type == PacketType::kPairAnswer;
  }

  posix::UdpSocket socket_;
  LinkTarget target_;
  posix::SocketAddress from_;
};

}  // namespace

std::expected<std::unique_ptr<ControlTransport>, ControlError> open_link_transport(
    const LinkTarget& target) {
  posix::UdpSocket socket(AF_INET);
  int error = socket.is_open() ? 0 : errno;
  if (error == 0) {
    error = socket.set(std::array{posix::SocketOption{SOL_SOCKET, SO_REUSEADDR, 1},
                                  posix::SocketOption{SOL_SOCKET, SO_BROADCAST, 1},
                                  posix::SocketOption{IPPROTO_IP, IP_TTL, 1}});
  }
  if (error == 0) {
    error = socket.bind(posix::make_address(in_addr{}, kLinkPort));
  }
  if (error != 0) {
    return std::unexpected(ControlError{
        .status = Status::kDeviceError,
        .message = "UDP port " + std::to_string(kLinkPort) + ": " + std::strerror(error) +
                   ": another program has it for itself: close that"});
  }
  return std::make_unique<LinkTransport>(std::move(socket), target);
}

}  // namespace stof::client

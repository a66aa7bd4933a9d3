#include "host/client/sensor_socket.h"

#include <array>
#include <cerrno>
#include <cstring>

#include "posix/poll.h"

namespace stof::client {
namespace {

std::unexpected<OpenError> refuse(Status status, std::string message) {
  return std::unexpected(OpenError{status, std::move(message)});
}

const char* bind_advice(int error) {
  switch (error) {
    case EADDRINUSE:
      return "close the program that uses it or take another port";
    case EADDRNOTAVAIL:
      return "no interface of this machine has that address: use one of its own, or 0.0.0.0 for "
             "all of them";
    case EACCES:
      return "take a port above 1023";
    default:
      return "take another port or address";
  }
}

}  // namespace

std::expected<std::vector<posix::SocketAddress>, OpenError> resolve_sensor(
    std::string_view sensor) {
  const std::string what = "sensor '" + std::string(sensor) + "': ";
  const auto target = posix::split_host_port(sensor, kDefaultPort);
  if (!target) {
    return refuse(Status::kInvalidArgument,
                  what + "give HOST or HOST:PORT, such as 192.168.1.20 or [fe80::1%eth0]:7560");
  }
  auto addresses = posix::resolve(*target, posix::Names::kLookUp);
  if (!addresses) {
    return refuse(Status::kDeviceError,
                  what + addresses.error() + "; check the host's name or give its address");
  }
  return *std::move(addresses);
}

SensorSocket::SensorSocket(posix::UdpSocket socket, std::string place, int buffer_bytes)
    : socket_(std::move(socket)),
      place_(std::move(place)),
      buffer_bytes_(socket_.set_buffer(posix::UdpSocket::Buffer::kReceive, buffer_bytes)) {
  // Without these drops are not told, and what waits in the queue does not age.
  static_cast<void>(socket_.count_drops());
  static_cast<void>(socket_.stamp_arrivals());
}

std::expected<std::unique_ptr<SensorSocket>, OpenError> SensorSocket::open(
    const std::string& address, std::uint16_t port, int buffer_bytes) {
  const auto at = posix::resolve({.host = address, .port = port}, posix::Names::kAddressesOnly);
  if (!at) {
    return refuse(Status::kInvalidArgument,
                  "listening address '" + address +
                      "': not an IPv4 or IPv6 address; use 0.0.0.0 to listen at every interface");
  }
  const std::string place = "UDP port " + std::to_string(port) + " at " + address + ": ";
  posix::UdpSocket socket(at->front().family());
  if (!socket.is_open()) {
    return refuse(Status::kDeviceError,
                  place + std::strerror(errno) + "; this system gives no socket");
  }
  if (const int error = socket.bind(at->front()); error != 0) {
    return refuse(Status::kDeviceError, place + std::strerror(error) + "; " + bind_advice(error));
  }
  std::string own = address + ":" + std::to_string(socket.port());
  return std::unique_ptr<SensorSocket>(
      new SensorSocket(std::move(socket), std::move(own), buffer_bytes));
}

std::expected<std::unique_ptr<SensorSocket>, OpenError> SensorSocket::connect(
    std::string_view sensor, int buffer_bytes) {
  const auto addresses = resolve_sensor(sensor);
  if (!addresses) {
    return std::unexpected(addresses.error());
  }
  int error = EADDRNOTAVAIL;
  for (const posix::SocketAddress& address : *addresses) {
    posix::UdpSocket socket(address.family());
    error = socket.is_open() ? socket.connect(address) : errno;
    if (error == 0) {
      return std::unique_ptr<SensorSocket>(
          new SensorSocket(std::move(socket), address.text(), buffer_bytes));
    }
  }
  return refuse(Status::kDeviceError, "sensor '" + std::string(sensor) +
                                          "': " + std::strerror(error) +
                                          "; check the network and the route to that host");
}

// Refusals of what was sent before, and ways that are closed for now: the socket works on.
bool SensorSocket::passes(int error) {
  refused_ = refused_ || error == ECONNREFUSED;
  return posix::answers_earlier(error) || error == ENETDOWN || error == EPERM;
}

Status SensorSocket::send(std::span<const std::byte> datagram) {
  // The first error may answer an earlier datagram.
  for (int attempt = 0; attempt < 2; ++attempt) {
    const int error = socket_.send(datagram);
    if (error == 0) {
      return Status::kOk;
    }
    if (error == EAGAIN || error == ENOBUFS || error == ENOMEM) {
      return Status::kWouldBlock;
    }
    if (error != EINTR && !passes(error)) {
      return Status::kDeviceLost;
    }
  }
  return Status::kDeviceError;
}

Result<std::size_t> SensorSocket::receive() {
  // Every error that answers an earlier datagram hides what lies in the queue behind it; whoever
  // sends many of them must not make the queue look empty.
  constexpr int kMostAnswers = 64;
  const Time before = Time::clock::now();
  auto count = batch_.read(fd());
  for (int i = 0; i < kMostAnswers && !count && passes(count.error()); ++i) {
    count = batch_.read(fd());
  }
  if (count) {
    note_arrivals(*count, before);
    return *count;
  }
  const int error = count.error();
  if (error == EAGAIN) {
    note_arrivals(0, before);
  }
  const bool nothing = error == EAGAIN || error == EINTR || passes(error);
  return nothing ? Result<std::size_t>(0) : fail(Status::kDeviceLost);
}

void SensorSocket::note_arrivals(std::size_t count, Time before) {
  const ArrivalClock::Now now = ArrivalClock::now();
  clock_.read(now);
  for (std::size_t i = 0; i < count; ++i) {
    const auto stamp = batch_.arrived(i);
    arrived_[i] = stamp ? clock_.arrival(*stamp) : now.monotonic;
  }
  if (count < posix::DatagramBatch::kMost) {
    clock_.emptied(before);
  }
}

Status SensorSocket::wait(Duration timeout) const {
  std::array entries{pollfd{.fd = fd(), .events = POLLIN, .revents = 0}};
  const auto ready = posix::wait_for(entries, timeout);
  if (!ready || (entries[0].revents & POLLNVAL) != 0) {  // POLLERR: receive() hears which
    return Status::kDeviceLost;
  }
  return *ready > 0 ? Status::kOk : Status::kTimeout;
}

}  // namespace stof::client

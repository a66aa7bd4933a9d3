#include "host/client/sensor_address.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <memory>
#include <optional>
#include <system_error>

#include <netdb.h>
#include <netinet/in.h>

namespace stof::client {
namespace {

struct HostPort {
  std::string host;
  std::string port;
};

std::optional<HostPort> split(std::string_view text) {
  HostPort out{.host = std::string(text), .port = std::to_string(kDefaultPort)};
  std::size_t colon = text.rfind(':');
  if (text.starts_with('[')) {
    const std::size_t close = text.find(']');
    if (close == std::string_view::npos) {
      return std::nullopt;
    }
    out.host = text.substr(1, close - 1);
    if (close + 1 == text.size()) {
      return out.host.empty() ? std::nullopt : std::optional(out);
    }
    colon = close + 1;
    if (text[colon] != ':') {
      return std::nullopt;
    }
  } else if (colon == std::string_view::npos || text.find(':') != colon) {
    return text.empty() ? std::nullopt
                        : std::optional(out);  // no port; perhaps a bare IPv6 address
  } else {
    out.host = text.substr(0, colon);
  }
  out.port = text.substr(colon + 1);
  std::uint16_t number = 0;
  const auto [end, error] =
      std::from_chars(out.port.data(), out.port.data() + out.port.size(), number);
  if (out.host.empty() || error != std::errc{} || end != out.port.data() + out.port.size() ||
      number == 0) {
    return std::nullopt;
  }
  return out;
}

std::unexpected<OpenError> refuse(Status status, std::string_view sensor, std::string_view why) {
  std::string message = "sensor '";
  message.append(sensor).append("': ").append(why);
  return std::unexpected(OpenError{status, std::move(message)});
}

}  // namespace

sockaddr* SocketAddress::generic() noexcept {
  return reinterpret_cast<sockaddr*>(&storage);  // NOLINT: the sockets' own interface
}

std::uint16_t SocketAddress::port() const noexcept {
  // It stands at the same place in both families.
  sockaddr_in any{};
  std::memcpy(&any, &storage, sizeof any);
  return ntohs(any.sin_port);
}

std::string SocketAddress::text() const {
  std::array<char, NI_MAXHOST> host{};
  SocketAddress copy = *this;
  if (getnameinfo(copy.generic(), length, host.data(), host.size(), nullptr, 0, NI_NUMERICHOST) !=
      0) {
    return "unknown address";
  }
  const std::string name = host.data();
  const bool six = storage.ss_family == AF_INET6;
  return (six ? "[" + name + "]" : name) + ":" + std::to_string(port());
}

std::expected<std::vector<SocketAddress>, OpenError> resolve_sensor(std::string_view sensor) {
  const std::optional<HostPort> target = split(sensor);
  if (!target) {
    return refuse(Status::kInvalidArgument, sensor,
                  "give HOST or HOST:PORT, such as 192.168.1.20 or [fe80::1%eth0]:7560");
  }
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int lookup = getaddrinfo(target->host.c_str(), target->port.c_str(), &hints, &found);
  if (lookup != 0) {
    std::string why = gai_strerror(lookup);
    return refuse(Status::kDeviceError, sensor,
                  why.append("; check the host's name or give its address"));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, freeaddrinfo);
  std::vector<SocketAddress> addresses;
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    SocketAddress& address = addresses.emplace_back();
    address.length = std::min<socklen_t>(entry->ai_addrlen, sizeof address.storage);
    std::memcpy(&address.storage, entry->ai_addr, address.length);
  }
  return addresses;
}

}  // namespace stof::client

#include "hal/linux/ports/peer_address.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <memory>
#include <string>
#include <system_error>

#include <netdb.h>
#include <netinet/in.h>

namespace stof::hal::linux {
namespace {

// ::ffff:a.b.c.d
constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};

struct HostPort {
  std::string host;
  std::string port;
};

std::optional<HostPort> split(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return std::nullopt;
  }
  std::uint16_t number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (host.empty() || error != std::errc{} || end != port.data() + port.size() || number == 0) {
    return std::nullopt;
  }
  return HostPort{std::string(host), std::string(port)};
}

std::unexpected<OpenError> refuse(std::string_view destination, std::string_view why) {
  std::string message = "cannot send to '";
  message.append(destination).append("': ").append(why);
  return std::unexpected(OpenError{std::move(message)});
}

template <typename Address>
SocketAddress stored(const Address& address) noexcept {
  SocketAddress out;
  std::memcpy(&out.storage, &address, sizeof address);
  out.length = sizeof address;
  return out;
}

// A static program has no resolver: that of glibc is made of shared libraries of its own version.
#if defined(STOF_STATIC)
constexpr int kOnlyAddresses = AI_NUMERICHOST;
#else
constexpr int kOnlyAddresses = 0;
#endif

}  // namespace

std::expected<Peer, OpenError> resolve(std::string_view destination) {
  const std::optional<HostPort> target = split(destination);
  if (!target) {
    return refuse(destination, "give HOST:PORT, such as 192.168.1.20:5600 or [::1]:5600");
  }
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV | kOnlyAddresses;
  addrinfo* found = nullptr;
  const int lookup = getaddrinfo(target->host.c_str(), target->port.c_str(), &hints, &found);
  if (lookup != 0) {
    std::string why = gai_strerror(lookup);
    return refuse(destination,
                  why.append(kOnlyAddresses != 0 ? "; give the host's address, not a name"
                                                 : "; check the host's name or give its address"));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    sockaddr_storage storage{};
    std::memcpy(&storage, entry->ai_addr, std::min<std::size_t>(entry->ai_addrlen, sizeof storage));
    if (const std::optional<Peer> peer = to_peer(storage)) {
      return *peer;
    }
  }
  return refuse(destination, "the name has no IP address; give an address");
}

std::optional<SocketAddress> to_socket_address(const Peer& peer, int family) noexcept {
  if (family == AF_INET6) {
    sockaddr_in6 v6{};
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(peer.port);
    v6.sin6_scope_id = peer.scope;
    std::memcpy(&v6.sin6_addr, peer.address.data(), peer.address.size());
    return stored(v6);
  }
  if (!std::ranges::equal(std::span(peer.address).first<kMapped.size()>(), kMapped)) {
    return std::nullopt;
  }
  sockaddr_in v4{};
  v4.sin_family = AF_INET;
  v4.sin_port = htons(peer.port);
  std::memcpy(&v4.sin_addr, &peer.address[kMapped.size()], sizeof v4.sin_addr);
  return stored(v4);
}

std::optional<Peer> to_peer(const sockaddr_storage& address) noexcept {
  Peer peer;
  if (address.ss_family == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &address, sizeof v6);
    std::memcpy(peer.address.data(), &v6.sin6_addr, peer.address.size());
    peer.port = ntohs(v6.sin6_port);
    peer.scope = v6.sin6_scope_id;
    return peer;
  }
  if (address.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address, sizeof v4);
    std::ranges::copy(kMapped, peer.address.begin());
    std::memcpy(&peer.address[kMapped.size()], &v4.sin_addr, sizeof v4.sin_addr);
    peer.port = ntohs(v4.sin_port);
    return peer;
  }
  return std::nullopt;
}

}  // namespace stof::hal::linux

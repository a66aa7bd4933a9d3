#include "hal/linux/link_udp.h"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace stof::hal::posix {
namespace {

struct HostPort {
  std::string host;
  std::string port;
};

// "host:port" or "[v6]:port".
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

bool set_option(int fd, int level, int name, int value) noexcept {
  return setsockopt(fd, level, name, &value, sizeof value) == 0;
}

// Never fragments: what does not fit the path is EMSGSIZE.
bool forbid_fragments(int fd, int family) noexcept {
  return family == AF_INET6 ? set_option(fd, IPPROTO_IPV6, IPV6_MTU_DISCOVER, IPV6_PMTUDISC_DO)
                            : set_option(fd, IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_DO);
}

Status status_of(int error) noexcept {
  switch (error) {
    case EAGAIN:
    case ENOBUFS:
    case ENOMEM:
      return Status::kWouldBlock;
    case EMSGSIZE:
      return Status::kTooLarge;
    case EBADF:
    case ENOTSOCK:
    case EPIPE:
      return Status::kDeviceLost;
    default:  // ECONNREFUSED, ENETUNREACH, EHOSTUNREACH, ENETDOWN, EPERM (a firewall), ...
      return Status::kDeviceError;
  }
}

}  // namespace

std::expected<UdpLink, OpenError> UdpLink::open(std::string_view destination, int send_buffer) {
  const std::optional<HostPort> target = split(destination);
  if (!target) {
    return refuse(destination, "give HOST:PORT, such as 192.168.1.20:5600 or [::1]:5600");
  }
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int lookup = getaddrinfo(target->host.c_str(), target->port.c_str(), &hints, &found);
  if (lookup != 0) {
    std::string why = gai_strerror(lookup);
    return refuse(destination, why.append("; check the host's name or give its address"));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  int error = 0;
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    UdpLink link(socket(address->ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (link.fd_ >= 0 && forbid_fragments(link.fd_, address->ai_family) &&
        set_option(link.fd_, SOL_SOCKET, SO_SNDBUF, send_buffer) &&
        connect(link.fd_, address->ai_addr, address->ai_addrlen) == 0) {
      return link;
    }
    error = errno;
  }
  std::string why = std::strerror(error);
  return refuse(destination, why.append("; check the network and the route to that host"));
}

UdpLink::UdpLink(UdpLink&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

UdpLink& UdpLink::operator=(UdpLink&& other) noexcept {
  std::swap(fd_, other.fd_);  // the old socket closes with `other`
  return *this;
}

UdpLink::~UdpLink() {
  if (fd_ >= 0) {
    close(fd_);
  }
}

Status UdpLink::send(std::span<const std::byte> datagram) noexcept {
  if (datagram.size() > kMaxDatagram) {
    return Status::kTooLarge;
  }
  bool refused = false;
  for (;;) {
    if (::send(fd_, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0) {
      return refused ? Status::kDeviceError : Status::kOk;
    }
    // This error answers an earlier datagram and kept this one back. It is told, but whoever began
    // to listen in between must not lose a datagram for it.
    if (errno == ECONNREFUSED && !refused) {
      refused = true;
    } else if (errno != EINTR) {
      return status_of(errno);
    }
  }
}

}  // namespace stof::hal::posix

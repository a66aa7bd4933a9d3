#include "hal/linux/ports/network_interfaces.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

namespace stof::hal::linux {
namespace {

using Address = std::array<std::uint8_t, 16>;

// Netlink messages lie in aligned memory of ours, but their parts are copied out all the same.
template <typename T>
std::optional<T> head_of(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() < sizeof(T)) {
    return std::nullopt;
  }
  T value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

constexpr std::size_t aligned(std::size_t bytes) noexcept {
  return (bytes + NLMSG_ALIGNTO - 1) / NLMSG_ALIGNTO * NLMSG_ALIGNTO;
}

std::span<const std::byte> rest_after(std::span<const std::byte> bytes,
                                      std::size_t count) noexcept {
  return bytes.subspan(std::min(aligned(count), bytes.size()));
}

std::optional<Address> address_of(std::span<const std::byte> data) noexcept {
  Address address = from_ipv4(0, 0, 0, 0);
  if (data.size() == 4) {
    std::memcpy(&address[12], data.data(), 4);
    return address;
  }
  if (data.size() == 16) {
    std::memcpy(address.data(), data.data(), 16);
    return address;
  }
  return std::nullopt;
}

// The body of an RTM_NEWADDR.
std::optional<InterfaceAddress> parse_address(std::span<const std::byte> body) noexcept {
  const auto head = head_of<ifaddrmsg>(body);
  if (!head || (head->ifa_family != AF_INET && head->ifa_family != AF_INET6)) {
    return std::nullopt;
  }
  std::optional<Address> address;
  std::optional<Address> local;
  InterfaceAddress out{.interface = head->ifa_index};
  for (auto rest = rest_after(body, sizeof(ifaddrmsg));;) {
    const auto attribute = head_of<rtattr>(rest);
    if (!attribute || attribute->rta_len < sizeof(rtattr) || attribute->rta_len > rest.size()) {
      break;
    }
    const auto data = rest.first(attribute->rta_len).subspan(sizeof(rtattr));
    if (attribute->rta_type == IFA_ADDRESS) {
      address = address_of(data);
    } else if (attribute->rta_type == IFA_LOCAL) {
      local = address_of(data);  // of a point-to-point interface the own end
    } else if (attribute->rta_type == IFA_BROADCAST) {
      out.broadcast = address_of(data).value_or(Address{});
    }
    rest = rest_after(rest, attribute->rta_len);
  }
  // What may still turn out to be somebody else's is no address yet.
  constexpr unsigned kUnsure = IFA_F_TENTATIVE | IFA_F_DADFAILED;
  if ((!address && !local) || (head->ifa_flags & kUnsure) != 0) {
    return std::nullopt;
  }
  out.address = local ? *local : *address;
  const unsigned offset = head->ifa_family == AF_INET ? 96 : 0;
  out.prefix_bits = static_cast<std::uint8_t>(std::min(offset + head->ifa_prefixlen, 128U));
  return out;
}

}  // namespace

NetworkInterfaces::NetworkInterfaces() noexcept
    : netlink_(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)),
      any_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  // The kernel answers at once or not at all.
  const timeval patience{.tv_sec = 0, .tv_usec = 10'000};
  static_cast<void>(setsockopt(netlink_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience));
}

NetworkInterfaces::~NetworkInterfaces() {
  for (const int fd : {netlink_, any_}) {
    if (fd >= 0) {
      close(fd);
    }
  }
}

bool NetworkInterfaces::request() noexcept {
  struct {
    nlmsghdr head;
    ifaddrmsg body;
  } message{};
  message.head.nlmsg_len = sizeof message;
  message.head.nlmsg_type = RTM_GETADDR;
  message.head.nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP;
  message.head.nlmsg_seq = ++sequence_;
  message.body.ifa_family = AF_UNSPEC;
  return ::send(netlink_, &message, sizeof message, 0) == static_cast<ssize_t>(sizeof message);
}

bool NetworkInterfaces::interface_flags(unsigned index, unsigned& flags) const noexcept {
  ifreq request{};
  request.ifr_ifindex = static_cast<int>(index);
  if (ioctl(any_, SIOCGIFNAME, &request) != 0 || ioctl(any_, SIOCGIFFLAGS, &request) != 0) {
    return false;
  }
  flags = static_cast<unsigned>(static_cast<unsigned short>(request.ifr_flags));
  return true;
}

std::size_t NetworkInterfaces::addresses(std::span<InterfaceAddress> space) noexcept {
  if (!request()) {
    return 0;
  }
  std::size_t count = 0;
  for (;;) {
    const ssize_t got = recv(netlink_, buffer_.data(), buffer_.size(), 0);
    if (got <= 0) {
      return count;
    }
    for (auto rest = std::span<const std::byte>(buffer_).first(static_cast<std::size_t>(got));;) {
      const auto head = head_of<nlmsghdr>(rest);
      if (!head || head->nlmsg_len < sizeof(nlmsghdr) || head->nlmsg_len > rest.size()) {
        break;
      }
      const bool ours = head->nlmsg_seq == sequence_;
      if (ours && (head->nlmsg_type == NLMSG_DONE || head->nlmsg_type == NLMSG_ERROR)) {
        return count;
      }
      const auto body = rest.first(head->nlmsg_len).subspan(aligned(sizeof(nlmsghdr)));
      const auto address =
          ours && head->nlmsg_type == RTM_NEWADDR ? parse_address(body) : std::nullopt;
      unsigned flags = 0;
      if (address && count < space.size() && interface_flags(address->interface, flags) &&
          (flags & IFF_UP) != 0) {
        InterfaceAddress& out = space[count++];
        out = *address;
        out.multicast = (flags & IFF_MULTICAST) != 0;
        if ((flags & IFF_LOOPBACK) != 0 && is_ipv4(out.address)) {
          out.broadcast = from_ipv4(127, 255, 255, 255);
        }
      }
      rest = rest_after(rest, head->nlmsg_len);
    }
  }
}

}  // namespace stof::hal::linux

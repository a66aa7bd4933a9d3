#include "posix/interfaces.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include <ifaddrs.h>
#include <net/if.h>

namespace stof::posix {
namespace {

std::optional<SocketAddress> address_of(const sockaddr* of_system) {
  if (of_system == nullptr) {
    return std::nullopt;
  }
  SocketAddress out;
  if (of_system->sa_family == AF_INET) {
    out.length = sizeof(sockaddr_in);
  } else if (of_system->sa_family == AF_INET6) {
    out.length = sizeof(sockaddr_in6);
  } else {
    return std::nullopt;
  }
  std::memcpy(&out.storage, of_system, out.length);
  return out;
}

std::optional<in_addr> ipv4_of(const std::optional<SocketAddress>& address) {
  if (!address || address->family() != AF_INET) {
    return std::nullopt;
  }
  sockaddr_in ipv4{};
  std::memcpy(&ipv4, &address->storage, sizeof ipv4);
  return ipv4.sin_addr;
}

void add_once(unsigned index, std::vector<unsigned>& indices) {
  if (std::ranges::find(indices, index) == indices.end()) {
    indices.push_back(index);
  }
}

}  // namespace

std::vector<InterfaceEntry> interface_entries() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return {};
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owned(list, freeifaddrs);
  std::vector<InterfaceEntry> out;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    InterfaceEntry one{.name = entry->ifa_name,
                       .index = if_nametoindex(entry->ifa_name),
                       .flags = entry->ifa_flags,
                       .address = address_of(entry->ifa_addr)};
    // In its place stands the other end of a line from point to point.
    if ((entry->ifa_flags & IFF_BROADCAST) != 0) {
      one.broadcast = ipv4_of(address_of(entry->ifa_broadaddr));
    }
    out.push_back(std::move(one));
  }
  return out;
}

Interfaces list_interfaces() {
  Interfaces out;
  for (const InterfaceEntry& entry : interface_entries()) {
    if ((entry.flags & IFF_UP) == 0) {
      continue;
    }
    if ((entry.flags & IFF_MULTICAST) != 0) {
      add_once(entry.index, out.multicast);
    }
    if ((entry.flags & (IFF_BROADCAST | IFF_LOOPBACK)) == IFF_BROADCAST) {
      add_once(entry.index, out.links);
    }
    if (entry.broadcast) {
      out.broadcasts.push_back(*entry.broadcast);
    }
  }
  return out;
}

bool is_own_address(const in_addr& address) {
  return std::ranges::any_of(interface_entries(), [&](const InterfaceEntry& entry) {
    const std::optional<in_addr> own = ipv4_of(entry.address);
    return own && own->s_addr == address.s_addr;
  });
}

}  // namespace stof::posix

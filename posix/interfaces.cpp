#include "posix/interfaces.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include <ifaddrs.h>
#include <net/if.h>

namespace stof::posix {

Interfaces list_interfaces() {
  Interfaces out;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return out;
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owned(list, freeifaddrs);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if ((entry->ifa_flags & IFF_UP) == 0) {
      continue;
    }
    const unsigned index = if_nametoindex(entry->ifa_name);
    if ((entry->ifa_flags & IFF_MULTICAST) != 0 &&
        std::ranges::find(out.multicast, index) == out.multicast.end()) {
      out.multicast.push_back(index);
    }
    const unsigned to_hosts = entry->ifa_flags & (IFF_BROADCAST | IFF_LOOPBACK);
    if (to_hosts == IFF_BROADCAST && std::ranges::find(out.links, index) == out.links.end()) {
      out.links.push_back(index);
    }
    const sockaddr* const broadcast = entry->ifa_broadaddr;
    if ((entry->ifa_flags & IFF_BROADCAST) != 0 && broadcast != nullptr &&
        broadcast->sa_family == AF_INET) {
      sockaddr_in address{};
      std::memcpy(&address, broadcast, sizeof address);
      out.broadcasts.push_back(address.sin_addr);
    }
  }
  return out;
}

bool is_own_address(const in_addr& address) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return false;
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owned(list, freeifaddrs);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) {
      continue;
    }
    sockaddr_in own{};
    std::memcpy(&own, entry->ifa_addr, sizeof own);
    if (own.sin_addr.s_addr == address.s_addr) {
      return true;
    }
  }
  return false;
}

}  // namespace stof::posix

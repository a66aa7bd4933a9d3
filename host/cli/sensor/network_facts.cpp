#include "host/cli/sensor/network_facts.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>

#include <ifaddrs.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/timex.h>

#include "host/client/sensor_socket.h"
#include "posix/socket_address.h"
#include "posix/udp_socket.h"

namespace stof::host {
namespace {

std::optional<int> number_in(const std::string& file) {
  std::ifstream in(file);
  int value = 0;
  return in >> value && value > 0 ? std::optional(value) : std::nullopt;
}

// The host part of an address of the system's list; empty: of another family.
std::string host_of(const sockaddr* address) {
  posix::SocketAddress copy;
  if (address == nullptr) {
    return {};
  }
  if (address->sa_family == AF_INET) {
    std::memcpy(&copy.storage, address, sizeof(sockaddr_in));
  } else if (address->sa_family == AF_INET6) {
    std::memcpy(&copy.storage, address, sizeof(sockaddr_in6));
  } else {
    return {};
  }
  return copy.host();
}

void find_interface(const std::string& host, NetworkFacts& facts) {
  ifaddrs* list = nullptr;
  if (host.empty() || getifaddrs(&list) != 0) {
    return;
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owned(list, freeifaddrs);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (host_of(entry->ifa_addr) == host) {
      facts.interface = entry->ifa_name;
      facts.loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0;
      return;
    }
  }
}

std::optional<int> mtu_of(int fd, const std::string& interface) {
  ifreq request{};
  if (interface.empty() || interface.size() >= IFNAMSIZ) {
    return std::nullopt;
  }
  std::memcpy(request.ifr_name, interface.c_str(), interface.size() + 1);
  return ::ioctl(fd, SIOCGIFMTU, &request) == 0 ? std::optional(request.ifr_mtu) : std::nullopt;
}

std::optional<bool> wall_clock_is_synchronised() {
  timex state{};  // asks, and sets nothing
  if (::adjtimex(&state) < 0) {
    return std::nullopt;
  }
  return (state.status & STA_UNSYNC) == 0;
}

}  // namespace

NetworkFacts network_facts(int fd) {
  NetworkFacts facts;
  posix::SocketAddress own;
  if (::getsockname(fd, own.generic(), &own.length) == 0) {
    find_interface(own.host(), facts);
  }
  facts.mtu = mtu_of(fd, facts.interface);
  if (!facts.interface.empty() && !facts.loopback) {
    facts.speed_mbit = number_in("/sys/class/net/" + facts.interface + "/speed");
  }
  facts.most_buffer = number_in("/proc/sys/net/core/rmem_max");
  facts.clock_synchronised = wall_clock_is_synchronised();
  return facts;
}

bool sending_is_refused(const std::string& address) {
  const auto addresses = client::resolve_sensor(address);
  if (!addresses) {
    return false;
  }
  const posix::UdpSocket socket(addresses->front().family());
  // One byte, which every sensor drops.
  const std::array<std::byte, 1> nothing{};
  return socket.is_open() && socket.send_to(addresses->front(), nothing) == EPERM;
}

}  // namespace stof::host

#include "host/cli/sensor/network_facts.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/timex.h>

#include "host/client/sensor_socket.h"
#include "posix/interfaces.h"
#include "posix/socket_address.h"
#include "posix/udp_socket.h"

namespace stof::host {
namespace {

std::optional<int> number_in(const std::string& file) {
  std::ifstream in(file);
  int value = 0;
  return in >> value && value > 0 ? std::optional(value) : std::nullopt;
}

void find_interface(const std::string& host, NetworkFacts& facts) {
  if (host.empty()) {
    return;
  }
  for (const posix::InterfaceEntry& entry : posix::interface_entries()) {
    if (entry.address && entry.address->host() == host) {
      facts.interface = entry.name;
      facts.loopback = (entry.flags & IFF_LOOPBACK) != 0;
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

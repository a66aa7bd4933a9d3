#pragma once

#include <array>
#include <chrono>
#include <cstddef>

#include <netinet/in.h>
#include <sys/socket.h>

#include "posix/poll.h"
#include "posix/udp_socket.h"
#include "tests/support/loopback.h"

// What not every system does for UDP sockets; qemu-user leaves some of it out.
namespace stof::test {

inline bool takes_option(int level, int name) {
  return posix::UdpSocket(AF_INET).set({level, name, 1}) == 0;
}

inline bool counts_overruns() { return takes_option(SOL_SOCKET, SO_RXQ_OVFL); }

// Whether an answer "nobody listens there" comes back through the error queue: it is tried.
inline bool tells_refusals() {
  const posix::UdpSocket probe(AF_INET);
  const std::array<std::byte, 1> question{std::byte{'?'}};
  // tcpmux: nobody speaks it over UDP
  bool told = probe.set({IPPROTO_IP, IP_RECVERR, 1}) == 0 &&
              probe.send_to(loopback_address(1), question) == 0;
  std::array waiting{pollfd{.fd = probe.fd(), .events = 0, .revents = 0}};
  told = told && posix::wait_for(waiting, std::chrono::milliseconds(200)) == 1;
  alignas(cmsghdr) std::array<char, 512> control{};
  msghdr message{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  told = told && recvmsg(probe.fd(), &message, MSG_ERRQUEUE) >= 0;
  const cmsghdr* const header = told ? CMSG_FIRSTHDR(&message) : nullptr;
  told = header != nullptr && header->cmsg_level == IPPROTO_IP && header->cmsg_type == IP_RECVERR;
  return told;
}

// Whether a datagram comes with the address that it was sent to, and one can be sent from there.
inline bool tells_own_address() {
  const posix::UdpSocket probe(AF_INET);
  const std::array<std::byte, 1> question{std::byte{'?'}};
  bool told = probe.tell_own_address(AF_INET) == 0 && probe.bind(loopback_address(0)) == 0 &&
              probe.send_to(loopback_address(probe.port()), question) == 0;
  std::array waiting{pollfd{.fd = probe.fd(), .events = POLLIN, .revents = 0}};
  told = told && posix::wait_for(waiting, std::chrono::milliseconds(200)) == 1;
  alignas(cmsghdr) std::array<char, 512> control{};
  msghdr message{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  told = told && recvmsg(probe.fd(), &message, 0) >= 0;
  const cmsghdr* const header = told ? CMSG_FIRSTHDR(&message) : nullptr;
  return header != nullptr && header->cmsg_level == IPPROTO_IP && header->cmsg_type == IP_PKTINFO;
}

}  // namespace stof::test

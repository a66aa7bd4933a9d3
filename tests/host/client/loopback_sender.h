#pragma once

#include <cstdint>
#include <cstring>
#include <span>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "dsp/base/status.h"

namespace stof::test {

// Sends datagrams to a UDP port of this machine.
class LoopbackSender {
 public:
  explicit LoopbackSender(std::uint16_t port) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sockaddr generic{};
    static_assert(sizeof generic == sizeof to);
    std::memcpy(&generic, &to, sizeof to);
    connected_ = fd_ >= 0 && connect(fd_, &generic, sizeof generic) == 0;
  }
  ~LoopbackSender() { close(fd_); }
  LoopbackSender(const LoopbackSender&) = delete;
  LoopbackSender& operator=(const LoopbackSender&) = delete;

  bool connected() const { return connected_; }

  Status send(std::span<const std::byte> datagram) noexcept {
    const ssize_t sent = ::send(fd_, datagram.data(), datagram.size(), 0);
    return sent == static_cast<ssize_t>(datagram.size()) ? Status::kOk : Status::kDeviceError;
  }

 private:
  int fd_;
  bool connected_ = false;
};

}  // namespace stof::test

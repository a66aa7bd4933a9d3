#pragma once

#include <cstdint>
#include <cstring>
#include <expected>
#include <string>
#include <utility>

#include <sys/socket.h>
#include <unistd.h>

// What the relay needs of the sockets' interface.
namespace stof::link {

struct Address {
  sockaddr_storage storage{};
  socklen_t length = sizeof(sockaddr_storage);

  sockaddr* generic() {
    return reinterpret_cast<sockaddr*>(&storage);  // NOLINT: the sockets' own interface
  }
  const sockaddr* generic() const {
    return reinterpret_cast<const sockaddr*>(&storage);  // NOLINT: the sockets' own interface
  }
  friend bool operator==(const Address& a, const Address& b) {
    return a.length == b.length && std::memcmp(&a.storage, &b.storage, a.length) == 0;
  }
};

// Owns a descriptor. Asks for buffers of 4 MiB.
class Socket {
 public:
  explicit Socket(int fd = -1);
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() {
    if (fd_ >= 0) {
      close(fd_);
    }
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

// Without blocking; fd() is -1 where the system gives none.
Socket udp_socket(int family);

// An address literal. The error is the system's word for it.
std::expected<Address, std::string> resolve_literal(const std::string& host, std::uint16_t port);
// HOST:PORT, an IPv6 literal in brackets. The error is a line for a person.
std::expected<Address, std::string> resolve_place(const std::string& text);

std::uint16_t bound_port(int fd);

}  // namespace stof::link

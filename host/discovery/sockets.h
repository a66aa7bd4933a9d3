#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>

namespace stof::client {

// A UDP socket of one kind of address that neither blocks nor connects.
class AskingSocket {
 public:
  // port 0: any free one; another one may be shared with other programs. Without it if the system
  // does not give it: is_open().
  AskingSocket(int family, std::uint16_t port);
  ~AskingSocket();
  AskingSocket(const AskingSocket&) = delete;
  AskingSocket& operator=(const AskingSocket&) = delete;

  bool is_open() const { return fd_ >= 0; }
  int fd() const { return fd_; }
  int family() const { return family_; }

  // What cannot be sent is not.
  void send(const sockaddr_storage& to, std::span<const std::byte> datagram) const;
  // To a multicast group by one interface.
  void send_by(unsigned interface, const sockaddr_storage& to,
               std::span<const std::byte> datagram) const;

  struct Read {
    std::span<const std::byte> datagram;  // in `space`
    std::string from;                     // numeric address
  };
  std::optional<Read> receive(std::span<std::byte> space) const;

 private:
  int family_;
  int fd_;
};

sockaddr_storage make_address(const in_addr& address, std::uint16_t port);
sockaddr_storage make_address(const in6_addr& address, std::uint16_t port, unsigned scope = 0);
// HOST[:PORT]; nothing: not an address, not a known name.
std::optional<sockaddr_storage> look_up(const std::string& text, std::uint16_t default_port);

// What this machine's network looks like.
struct Interfaces {
  std::vector<in_addr> broadcasts;
  std::vector<unsigned> multicast;  // indices
};
Interfaces list_interfaces();

}  // namespace stof::client

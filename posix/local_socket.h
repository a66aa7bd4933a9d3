#pragma once

#include <cstddef>
#include <expected>
#include <span>
#include <string>
#include <string_view>

#include <sys/un.h>

#include "posix/fd.h"

namespace stof::posix {

// A datagram socket that programs of one machine and one user talk by, with a name in the file
// system. An int that is returned or expected is an errno, 0: fine.
class LocalSocket {
 public:
  // Room for one datagram of either side.
  static constexpr std::size_t kMostBytes = 4096;

  // Waits to be asked at `path`, which this user alone may use (mode 0600). A socket that nobody
  // serves any more is replaced; EADDRINUSE: somebody does; EEXIST: something else has the name;
  // ENAMETOOLONG. Its file stays when it is closed.
  static std::expected<LocalSocket, int> serve(const std::string& path) noexcept;
  // Asks whoever serves there. ENOENT, ECONNREFUSED: nobody does.
  static std::expected<LocalSocket, int> connect(const std::string& path) noexcept;

  struct Peer {
    sockaddr_un address{};
    unsigned length = 0;
  };

  // Becomes readable when receive() has something. Nothing below blocks.
  int fd() const noexcept { return fd_.get(); }
  // The next datagram, the part of it that fits: its bytes. EAGAIN: there is none.
  std::expected<std::size_t, int> receive(std::span<char> space,
                                          Peer* from = nullptr) const noexcept;
  int send(std::string_view datagram) const noexcept;
  int answer(const Peer& to, std::string_view datagram) const noexcept;

 private:
  explicit LocalSocket(Fd fd) noexcept : fd_(std::move(fd)) {}
  Fd fd_;
};

}  // namespace stof::posix

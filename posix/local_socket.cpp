#include "posix/local_socket.h"

#include <cerrno>
#include <cstring>

#include <sys/socket.h>
#include <sys/stat.h>

namespace stof::posix {
namespace {

std::expected<LocalSocket::Peer, int> named(const std::string& path) noexcept {
  LocalSocket::Peer peer;
  if (path.empty() || path.size() >= sizeof peer.address.sun_path) {
    return std::unexpected(path.empty() ? ENOENT : ENAMETOOLONG);
  }
  peer.address.sun_family = AF_UNIX;
  std::memcpy(peer.address.sun_path, path.data(), path.size());
  peer.length = sizeof peer.address;
  return peer;
}

const sockaddr* generic(const LocalSocket::Peer& peer) noexcept {
  return reinterpret_cast<const sockaddr*>(&peer.address);  // NOLINT: as the system has it
}

int error_of(ssize_t result) noexcept { return result < 0 ? errno : 0; }

Fd open_socket() noexcept {
  return Fd(socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

}  // namespace

std::expected<LocalSocket, int> LocalSocket::serve(const std::string& path) noexcept {
  const std::expected<Peer, int> peer = named(path);
  if (!peer) {
    return std::unexpected(peer.error());
  }
  struct stat there{};
  if (lstat(path.c_str(), &there) == 0) {
    if (!S_ISSOCK(there.st_mode)) {
      return std::unexpected(EEXIST);
    }
    if (connect(path)) {
      return std::unexpected(EADDRINUSE);
    }
    unlink(path.c_str());
  }
  LocalSocket made(open_socket());
  // Before it has its name: Linux gives the file the mode of the socket.
  if (!made.fd_.is_open() || fchmod(made.fd(), S_IRUSR | S_IWUSR) != 0 ||
      bind(made.fd(), generic(*peer), peer->length) != 0) {
    return std::unexpected(errno);
  }
  return made;
}

std::expected<LocalSocket, int> LocalSocket::connect(const std::string& path) noexcept {
  const std::expected<Peer, int> peer = named(path);
  if (!peer) {
    return std::unexpected(peer.error());
  }
  LocalSocket made(open_socket());
  // A name of its own that the system chooses: the answer goes there.
  Peer own;
  own.address.sun_family = AF_UNIX;
  if (!made.fd_.is_open() || bind(made.fd(), generic(own), sizeof own.address.sun_family) != 0 ||
      ::connect(made.fd(), generic(*peer), peer->length) != 0) {
    return std::unexpected(errno);
  }
  return made;
}

std::expected<std::size_t, int> LocalSocket::receive(std::span<char> space,
                                                     Peer* from) const noexcept {
  Peer peer;
  socklen_t length = sizeof peer.address;
  const ssize_t size =
      recvfrom(fd(), space.data(), space.size(), 0, reinterpret_cast<sockaddr*>(&peer.address),
               &length);  // NOLINT: see generic()
  if (size < 0) {
    return std::unexpected(errno);
  }
  peer.length = length;
  if (from != nullptr) {
    *from = peer;
  }
  return static_cast<std::size_t>(size);
}

int LocalSocket::send(std::string_view datagram) const noexcept {
  return error_of(::send(fd(), datagram.data(), datagram.size(), MSG_NOSIGNAL));
}

int LocalSocket::answer(const Peer& to, std::string_view datagram) const noexcept {
  return error_of(
      sendto(fd(), datagram.data(), datagram.size(), MSG_NOSIGNAL, generic(to), to.length));
}

}  // namespace stof::posix

#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "host/viewer/client_frames.h"
#include "host/viewer/page_rights.h"
#include "posix/fd.h"

namespace stof::viewer {

struct GuardOptions {
  bool every_interface = false;  // false: loopback alone
  std::uint16_t port = 0;        // 0: any free one
  // Connections that are no WebSocket yet: in all, and of one address. One more takes the place of
  // the oldest.
  std::size_t most_waiting = 64;
  std::size_t most_waiting_of_one = 32;
  // Until a request has come as a whole; and that an answer may stand still.
  std::chrono::milliseconds patience{4000};
};

// Stands before the web server, as libwebsockets 4.1 gives its places to connections that say
// nothing, accepts nobody once they are taken, and takes frames that are not masked. Accepts TCP
// connections, always and at once; passes on those whose request has come as a whole, one request
// each, through a pair of sockets; what a WebSocket's client sends then, but for frames that are
// not masked.
class ConnectionGuard {
 public:
  // What has sent a whole request: the server's end of it, and who it is. Of the guard's thread.
  using Admit = std::function<void(posix::Fd inner, const PageOrigin& origin)>;

  // None: the port cannot be had.
  static std::unique_ptr<ConnectionGuard> open(const GuardOptions& options, Admit admit);
  ~ConnectionGuard();
  ConnectionGuard(const ConnectionGuard&) = delete;
  ConnectionGuard& operator=(const ConnectionGuard&) = delete;

  std::uint16_t port() const noexcept;
  // Until stop(), which any thread may call.
  void run();
  void stop() noexcept;

 private:
  class Connection;
  using Clock = std::chrono::steady_clock;

  ConnectionGuard(const GuardOptions& options, Admit admit, posix::Fd listener, posix::Fd wake);
  void accept_all(Clock::time_point now);
  void make_room(std::uint32_t address);
  std::size_t waiting_of(std::uint32_t address) const;

  const GuardOptions options_;
  const Admit admit_;
  posix::Fd listener_;
  posix::Fd wake_;
  std::atomic<bool> stopping_ = false;
  Clock::time_point accepts_at_{};  // again, after the system had no more descriptors
  std::vector<std::unique_ptr<Connection>> connections_;  // the oldest first
};

}  // namespace stof::viewer

#include "hal/linux/system/local_orders.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>
#include <utility>

#include <unistd.h>

#include "posix/local_socket.h"
#include "posix/poll.h"

namespace stof::hal::linux {
namespace {

constexpr std::size_t kMostOrder = 256;
constexpr std::chrono::milliseconds kLook{100};  // how late it may end

std::string refusal(const std::string& path, int error) {
  switch (error) {
    case EADDRINUSE:
      return path + ": another program has this socket: give another path";
    case EEXIST:
      return path + ": something else has this name: give another path";
    case ENAMETOOLONG:
      return path + ": is too long for a socket: at most 107 bytes";
    default:
      return path + ": no socket can be made there (" + std::strerror(error) +  // NOLINT
             "): give a path in a folder of yours";
  }
}

}  // namespace

struct LocalOrders::Parts {
  std::string path;
  posix::LocalSocket socket;
  Obey obey;
  std::atomic<bool> stopping{false};
  std::thread thread{};

  ~Parts() {
    stopping = true;
    if (thread.joinable()) {
      thread.join();
    }
    unlink(path.c_str());
  }

  void run() const {
    std::array<char, kMostOrder + 1> space{};
    while (!stopping) {
      std::array<pollfd, 1> entries{{{.fd = socket.fd(), .events = POLLIN, .revents = 0}}};
      if (const auto ready = posix::wait_for(entries, kLook); !ready || *ready == 0) {
        continue;
      }
      posix::LocalSocket::Peer from;
      const auto size = socket.receive(space, &from);
      if (!size) {
        continue;
      }
      // Who is not there any more, or does not read, gets none.
      static_cast<void>(socket.answer(from, *size > kMostOrder
                                                ? "refused: an order has at most 256 bytes\n"
                                                : obey(std::string_view(space.data(), *size))));
    }
  }
};

LocalOrders::LocalOrders(std::unique_ptr<Parts> parts) noexcept : parts_(std::move(parts)) {}
LocalOrders::LocalOrders(LocalOrders&&) noexcept = default;
LocalOrders& LocalOrders::operator=(LocalOrders&&) noexcept = default;
LocalOrders::~LocalOrders() = default;

std::expected<LocalOrders, std::string> LocalOrders::open(const std::string& path, Obey obey) {
  auto socket = posix::LocalSocket::serve(path);
  if (!socket) {
    return std::unexpected(refusal(path, socket.error()));
  }
  std::unique_ptr<Parts> parts(
      new Parts{.path = path, .socket = std::move(*socket), .obey = std::move(obey)});  // NOLINT
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  parts->thread = std::thread([raw = parts.get()] { raw->run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return LocalOrders(std::move(parts));
}

}  // namespace stof::hal::linux

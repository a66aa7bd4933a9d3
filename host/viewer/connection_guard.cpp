#include "host/viewer/connection_guard.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <string_view>
#include <utility>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

namespace stof::viewer {
namespace {

constexpr std::size_t kMostRequest = 8192;
constexpr std::size_t kPart = 64 << 10;
constexpr int kMostUnsent =
    256 << 10;  // bytes that the system keeps: newer ones replace what waits
constexpr std::chrono::milliseconds kFarewell{1000};
constexpr std::chrono::milliseconds kNoDescriptors{100};
// Of a client that must be refused: its opcode means nothing, so that the server ends it with 1002.
constexpr std::array<std::uint8_t, 6> kSenselessFrame{0x83, 0x80, 0, 0, 0, 0};

std::string_view text_of(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};  // NOLINT
}

// What was done; 0 where it would have to wait; none: the end.
std::optional<std::size_t> done(ssize_t result) {
  if (result > 0) {
    return static_cast<std::size_t>(result);
  }
  if (result < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) {
    return 0;
  }
  return std::nullopt;
}

// False: the other end has gone.
bool send_from(const posix::Fd& to, std::vector<std::uint8_t>& bytes) {
  const auto sent = done(send(to.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
  if (sent) {
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(*sent));
  }
  return sent.has_value();
}

bool listen_at(const posix::Fd& listener, const GuardOptions& options) {
  const int yes = 1;
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(options.port);
  at.sin_addr.s_addr = htonl(options.every_interface ? INADDR_ANY : INADDR_LOOPBACK);
  return setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
         bind(listener.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0 &&  // NOLINT
         listen(listener.get(), SOMAXCONN) == 0;
}

}  // namespace

// One TCP connection, and the server's end of it once there is one.
class ConnectionGuard::Connection {
 public:
  Connection(posix::Fd outer, std::uint32_t address, Clock::time_point until)
      : outer_(std::move(outer)), address_(address), until_(until) {}

  std::uint32_t address() const noexcept { return address_; }
  bool waiting() const noexcept { return stage_ != Stage::kWebSocket; }
  bool ended() const noexcept { return stage_ == Stage::kEnded; }
  void end() noexcept {
    stage_ = Stage::kEnded;
    outer_.reset();
    inner_.reset();
  }
  std::optional<Clock::time_point> until() const noexcept {
    return stage_ == Stage::kWebSocket && !inner_ended_ ? std::nullopt : std::optional(until_);
  }

  void add_polled(std::vector<pollfd>& all);
  // The polled entries of add_polled(), with what came of them.
  void go_on(std::span<const pollfd> polled, Clock::time_point now,
             std::chrono::milliseconds patience, const Admit& admit);

 private:
  enum class Stage : std::uint8_t { kRequest, kAnswer, kWebSocket, kFarewell, kEnded };

  bool read_outer(const Admit& admit);
  bool read_inner();
  bool begin_answer(std::size_t size, const Admit& admit);

  posix::Fd outer_;
  posix::Fd inner_;
  std::uint32_t address_;
  Clock::time_point until_;
  Stage stage_ = Stage::kRequest;
  bool inner_ended_ = false;
  bool refused_ = false;           // nothing more of the client counts
  std::vector<std::uint8_t> in_;   // to the server
  std::vector<std::uint8_t> out_;  // to the client
  ClientFrames frames_;
};

void ConnectionGuard::Connection::add_polled(std::vector<pollfd>& all) {
  const bool passes = stage_ == Stage::kAnswer || stage_ == Stage::kWebSocket;
  const bool reads = stage_ == Stage::kRequest || stage_ == Stage::kFarewell ||
                     (stage_ == Stage::kWebSocket && in_.empty() && !refused_);
  const auto events = [](bool in, bool out) {
    return static_cast<short>((in ? POLLIN : 0) | (out ? POLLOUT : 0));
  };
  all.push_back({.fd = outer_.get(), .events = events(reads, !out_.empty()), .revents = 0});
  all.push_back({.fd = inner_ended_ ? -1 : inner_.get(),
                 .events = events(passes && out_.empty(), passes && !in_.empty()),
                 .revents = 0});
}

// The request, `size` bytes of what has come, goes to the server.
bool ConnectionGuard::Connection::begin_answer(std::size_t size, const Admit& admit) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return false;
  }
  inner_.reset(ends[0]);
  // What follows it would be before its turn: no browser sends a body, or speaks before the answer.
  in_.resize(size);
  stage_ = Stage::kAnswer;
  const bool upgrade = text_of(in_).find("ebsocket") != std::string_view::npos;
  admit(posix::Fd(ends[1]), upgrade ? origin_of(outer_.get()) : PageOrigin{});
  return true;
}

bool ConnectionGuard::Connection::read_outer(const Admit& admit) {
  std::array<std::uint8_t, kMostRequest> part{};
  const auto got = done(recv(outer_.get(), part.data(), part.size(), MSG_DONTWAIT));
  if (!got) {
    return false;
  }
  const std::span<const std::uint8_t> bytes = std::span(part).first(*got);
  if (stage_ == Stage::kWebSocket) {
    if (!frames_.take(bytes, in_)) {
      in_.insert(in_.end(), kSenselessFrame.begin(), kSenselessFrame.end());
      refused_ = true;
    }
    return true;
  }
  if (stage_ != Stage::kRequest) {
    return true;  // nobody listens any more
  }
  in_.insert(in_.end(), bytes.begin(), bytes.end());
  constexpr std::string_view kEnd = "\r\n\r\n";
  const std::size_t end = text_of(in_).find(kEnd);
  return end == std::string_view::npos ? in_.size() < kMostRequest
                                       : begin_answer(end + kEnd.size(), admit);
}

bool ConnectionGuard::Connection::read_inner() {
  constexpr std::string_view kSwitching = "HTTP/1.1 101";
  out_.resize(kPart);
  const auto got = done(recv(inner_.get(), out_.data(), out_.size(), MSG_DONTWAIT));
  out_.resize(got.value_or(0));
  if (stage_ == Stage::kAnswer && text_of(out_).starts_with(kSwitching)) {
    stage_ = Stage::kWebSocket;
  }
  return got.has_value();
}

void ConnectionGuard::Connection::go_on(std::span<const pollfd> polled, Clock::time_point now,
                                        std::chrono::milliseconds patience, const Admit& admit) {
  const auto has = [&](std::size_t which, int events) {
    return (polled[which].revents & events) != 0;
  };
  const Stage before = stage_;
  if (has(0, POLLIN | POLLHUP | POLLERR) && !read_outer(admit)) {
    end();
    return;
  }
  if (stage_ != before) {
    until_ = now + patience;
  }
  if (has(1, POLLOUT) && !in_.empty() && !send_from(inner_, in_)) {
    in_.clear();  // what the server says of it is still to come
    refused_ = true;
  }
  if (has(1, POLLIN | POLLHUP | POLLERR) && out_.empty() && !read_inner()) {
    inner_ended_ = true;
    until_ = now + kFarewell;
  }
  if (!out_.empty()) {
    const std::size_t size = out_.size();
    if (!send_from(outer_, out_)) {
      end();
      return;
    }
    if (out_.size() < size && !inner_ended_) {
      until_ = now + patience;
    }
  }
  if (inner_ended_ && out_.empty() && stage_ != Stage::kFarewell) {
    // Closed with something unread, the connection would be cut off, with the answer on the way.
    shutdown(outer_.get(), SHUT_WR);
    inner_.reset();
    stage_ = Stage::kFarewell;
  }
  if (const auto last = until(); last && now >= *last) {
    end();
  }
}

std::unique_ptr<ConnectionGuard> ConnectionGuard::open(const GuardOptions& options, Admit admit) {
  posix::Fd listener(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  posix::Fd wake(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!listener.is_open() || !wake.is_open() || !listen_at(listener, options)) {
    return nullptr;
  }
  return std::unique_ptr<ConnectionGuard>(
      new ConnectionGuard(options, std::move(admit), std::move(listener), std::move(wake)));
}

ConnectionGuard::ConnectionGuard(const GuardOptions& options, Admit admit, posix::Fd listener,
                                 posix::Fd wake)
    : options_(options),
      admit_(std::move(admit)),
      listener_(std::move(listener)),
      wake_(std::move(wake)) {}

ConnectionGuard::~ConnectionGuard() = default;

std::uint16_t ConnectionGuard::port() const noexcept {
  sockaddr_in at{};
  socklen_t size = sizeof at;
  getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&at), &size);  // NOLINT
  return ntohs(at.sin_port);
}

void ConnectionGuard::stop() noexcept {
  stopping_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_.get(), &one, sizeof one);
}

std::size_t ConnectionGuard::waiting_of(std::uint32_t address) const {
  return static_cast<std::size_t>(std::ranges::count_if(connections_, [&](const auto& one) {
    return !one->ended() && one->waiting() && one->address() == address;
  }));
}

// For one more of that address: who takes most places gives one up, the oldest.
void ConnectionGuard::make_room(std::uint32_t address) {
  const bool own = waiting_of(address) >= options_.most_waiting_of_one;
  const auto waiting = [](const auto& one) { return !one->ended() && one->waiting(); };
  const auto all = static_cast<std::size_t>(std::ranges::count_if(connections_, waiting));
  if (!own && all < options_.most_waiting) {
    return;
  }
  std::uint32_t most = address;
  for (const auto& one : connections_) {
    if (!own && waiting(one) && waiting_of(one->address()) > waiting_of(most)) {
      most = one->address();
    }
  }
  const auto oldest = std::ranges::find_if(
      connections_, [&](const auto& one) { return waiting(one) && one->address() == most; });
  if (oldest != connections_.end()) {
    (*oldest)->end();
  }
}

void ConnectionGuard::accept_all(Clock::time_point now) {
  constexpr int kAtOnce = 64;  // then those that are there have their turn
  for (int i = 0; i < kAtOnce; ++i) {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    posix::Fd outer(accept4(listener_.get(), reinterpret_cast<sockaddr*>(&from),  // NOLINT
                            &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!outer.is_open()) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
        accepts_at_ = now + kNoDescriptors;
      }
      return;
    }
    const int yes = 1;
    setsockopt(outer.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    setsockopt(outer.get(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kMostUnsent, sizeof kMostUnsent);
    make_room(from.sin_addr.s_addr);
    connections_.push_back(std::make_unique<Connection>(std::move(outer), from.sin_addr.s_addr,
                                                        now + options_.patience));
  }
}

void ConnectionGuard::run() {
  std::vector<pollfd> polled;
  while (!stopping_) {
    Clock::time_point now = Clock::now();
    const bool accepts = now >= accepts_at_;
    Clock::time_point until = accepts ? now + std::chrono::hours(1) : accepts_at_;
    polled.assign({{.fd = wake_.get(), .events = POLLIN, .revents = 0},
                   {.fd = accepts ? listener_.get() : -1, .events = POLLIN, .revents = 0}});
    for (const auto& one : connections_) {
      one->add_polled(polled);
      until = std::min(until, one->until().value_or(until));
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - now);
    poll(polled.data(), polled.size(), static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    now = Clock::now();
    const std::size_t known = connections_.size();
    for (std::size_t i = 0; i < known; ++i) {
      connections_[i]->go_on(std::span(polled).subspan(2 + 2 * i, 2), now, options_.patience,
                             admit_);
    }
    if (polled[1].revents != 0) {
      accept_all(now);
    }
    std::erase_if(connections_, [](const auto& one) { return one->ended(); });
  }
}

}  // namespace stof::viewer

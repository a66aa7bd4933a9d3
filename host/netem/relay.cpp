#include "host/netem/relay.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "posix/poll.h"
#include "posix/udp_socket.h"

namespace stof::netem {
namespace {

constexpr std::size_t kMostClients = 64;
constexpr Duration kIdle = std::chrono::minutes(1);
constexpr int kBufferBytes = 4 << 20;
constexpr int kBatch = 256;  // datagrams of one socket before the next one's turn

void add(Impairment::Counts& sum, const Impairment::Counts& counts) {
  sum.in += counts.in;
  sum.out += counts.out;
  sum.lost += counts.lost;
  sum.duplicated += counts.duplicated;
  sum.corrupted += counts.corrupted;
  sum.overflowed += counts.overflowed;
}

struct Client {
  posix::SocketAddress address;
  posix::UdpSocket socket;  // connected to upstream
  Impairment up;
  Impairment down;
  Time heard;
};

posix::UdpSocket open_socket(int family) {
  posix::UdpSocket socket(family);
  if (socket.is_open()) {
    static_cast<void>(socket.set_buffer(posix::UdpSocket::Buffer::kReceive, kBufferBytes));
    static_cast<void>(socket.set_buffer(posix::UdpSocket::Buffer::kSend, kBufferBytes));
  }
  return socket;
}

class UdpRelay final : public Relay {
 public:
  UdpRelay(RelayOptions options, const posix::SocketAddress& upstream, posix::UdpSocket socket)
      : options_(std::move(options)), upstream_(upstream), socket_(std::move(socket)) {}

  bool run(Duration timeout) override {
    const Time deadline = Time::clock::now() + timeout;
    while (true) {
      const Time now = Time::clock::now();
      if (!receive(now)) {
        return false;
      }
      forward(now);
      forget_idle(now);
      const Time until = std::min(deadline, next_due().value_or(deadline));
      wait(until - now);
      if (Time::clock::now() >= deadline) {
        return true;
      }
    }
  }

  std::uint16_t port() const override { return socket_.port(); }

  RelayCounts counts() const override {
    RelayCounts counts = gone_;
    counts.clients = clients_.size();
    for (const Client& client : clients_) {
      add(counts.up, client.up.counts());
      add(counts.down, client.down.counts());
    }
    return counts;
  }

 private:
  // From the clients and from upstream into the impairments.
  bool receive(Time now) {
    for (int i = 0; i < kBatch; ++i) {
      posix::SocketAddress from;
      const auto size = socket_.receive(buffer_, &from);
      if (!size) {
        if (size.error() != EAGAIN && size.error() != EINTR && size.error() != ECONNREFUSED) {
          return false;
        }
        break;
      }
      if (Client* const client = client_at(from, now)) {
        client->heard = now;
        client->up.push(std::span(buffer_).first(*size), now);
      }
    }
    for (Client& client : clients_) {
      for (int i = 0; i < kBatch; ++i) {
        const auto size = client.socket.receive(buffer_);
        if (!size) {  // also where upstream refuses: it may come back
          break;
        }
        client.down.push(std::span(buffer_).first(*size), now);
      }
    }
    return true;
  }

  // What the sockets do not take is lost, as on any network.
  void forward(Time now) {
    for (Client& client : clients_) {
      while (const auto datagram = client.up.pop(now)) {
        static_cast<void>(client.socket.send(*datagram));
      }
      while (const auto datagram = client.down.pop(now)) {
        static_cast<void>(socket_.send_to(client.address, *datagram));
      }
    }
  }

  Client* client_at(const posix::SocketAddress& from, Time now) {
    const auto known = std::ranges::find(clients_, from, &Client::address);
    if (known != clients_.end()) {
      return &*known;
    }
    posix::UdpSocket socket = open_socket(upstream_.family());
    if (clients_.size() == kMostClients || socket.connect(upstream_) != 0) {
      return nullptr;
    }
    const ImpairmentOptions good;
    ImpairmentOptions bad = options_.impairment;
    bad.seed += 2 * opened_++;  // each client and direction has a weather of its own
    const ImpairmentOptions up = options_.only == Direction::kDown ? good : bad;
    ++bad.seed;
    const ImpairmentOptions down = options_.only == Direction::kUp ? good : bad;
    clients_.push_back({.address = from,
                        .socket = std::move(socket),
                        .up = Impairment(up),
                        .down = Impairment(down),
                        .heard = now});
    return &clients_.back();
  }

  void forget_idle(Time now) {
    std::erase_if(clients_, [this, now](const Client& client) {
      if (now - client.heard < kIdle) {
        return false;
      }
      add(gone_.up, client.up.counts());
      add(gone_.down, client.down.counts());
      return true;
    });
  }

  std::optional<Time> next_due() const {
    std::optional<Time> first;
    for (const Client& client : clients_) {
      for (const Impairment* way : {&client.up, &client.down}) {
        if (const std::optional<Time> next = way->next()) {
          first = first ? std::min(*first, *next) : next;
        }
      }
    }
    return first;
  }

  void wait(Duration timeout) {
    entries_.assign(1, {.fd = socket_.fd(), .events = POLLIN, .revents = 0});
    for (const Client& client : clients_) {
      entries_.push_back({.fd = client.socket.fd(), .events = POLLIN, .revents = 0});
    }
    static_cast<void>(
        posix::wait_for(entries_, std::min<Duration>(timeout, std::chrono::seconds(1))));
  }

  RelayOptions options_;
  posix::SocketAddress upstream_;
  posix::UdpSocket socket_;
  std::vector<Client> clients_;
  std::vector<pollfd> entries_;
  std::uint64_t opened_ = 0;
  RelayCounts gone_;
  std::array<std::byte, 65'536> buffer_{};
};

}  // namespace

std::expected<std::unique_ptr<Relay>, std::string> Relay::open(const RelayOptions& options) {
  const std::string quoted = "'" + options.upstream + "': ";
  const auto place = posix::split_host_port(options.upstream);
  if (!place) {
    return std::unexpected(quoted + "is not HOST:PORT");
  }
  const auto upstream = posix::resolve(*place, posix::Names::kLookUp);
  if (!upstream) {
    return std::unexpected(quoted + upstream.error() + "; give HOST:PORT of the sensor");
  }
  const auto at = posix::resolve({.host = options.listen_address, .port = options.listen_port},
                                 posix::Names::kAddressesOnly);
  if (!at) {
    return std::unexpected("listening address '" + options.listen_address +
                           "': not an IPv4 or IPv6 address");
  }
  posix::UdpSocket socket = open_socket(at->front().family());
  const int error = socket.is_open() ? socket.bind(at->front()) : errno;
  if (error != 0) {
    return std::unexpected("UDP port " + std::to_string(options.listen_port) + " at " +
                           options.listen_address + ": " + std::strerror(error) +
                           "; close the program that uses it or take another port");
  }
  return std::make_unique<UdpRelay>(options, upstream->front(), std::move(socket));
}

}  // namespace stof::netem

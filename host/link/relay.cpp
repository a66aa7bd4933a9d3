#include "host/link/relay.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/socket.h>

#include "host/link/udp.h"

namespace stof::link {
namespace {

constexpr std::size_t kMostClients = 64;
constexpr Duration kIdle = std::chrono::minutes(1);
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
  Address address;
  Socket socket;  // connected to upstream
  Impairment up;
  Impairment down;
  Time heard;
};

class UdpRelay final : public Relay {
 public:
  UdpRelay(RelayOptions options, const Address& upstream, Socket socket)
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

  std::uint16_t port() const override { return bound_port(socket_.fd()); }

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
      Address from;
      const ssize_t size =
          recvfrom(socket_.fd(), buffer_.data(), buffer_.size(), 0, from.generic(), &from.length);
      if (size < 0) {
        if (errno != EAGAIN && errno != EINTR && errno != ECONNREFUSED) {
          return false;
        }
        break;
      }
      if (Client* const client = client_at(from, now)) {
        client->heard = now;
        client->up.push(std::span(buffer_).first(static_cast<std::size_t>(size)), now);
      }
    }
    for (Client& client : clients_) {
      for (int i = 0; i < kBatch; ++i) {
        const ssize_t size = recv(client.socket.fd(), buffer_.data(), buffer_.size(), 0);
        if (size < 0) {  // also where upstream refuses: it may come back
          break;
        }
        client.down.push(std::span(buffer_).first(static_cast<std::size_t>(size)), now);
      }
    }
    return true;
  }

  // What the sockets do not take is lost, as on any network.
  void forward(Time now) {
    for (Client& client : clients_) {
      while (const auto datagram = client.up.pop(now)) {
        static_cast<void>(send(client.socket.fd(), datagram->data(), datagram->size(), 0));
      }
      while (const auto datagram = client.down.pop(now)) {
        static_cast<void>(sendto(socket_.fd(), datagram->data(), datagram->size(), 0,
                                 client.address.generic(), client.address.length));
      }
    }
  }

  Client* client_at(const Address& from, Time now) {
    const auto known = std::ranges::find(clients_, from, &Client::address);
    if (known != clients_.end()) {
      return &*known;
    }
    Socket socket = udp_socket(upstream_.storage.ss_family);
    if (clients_.size() == kMostClients || socket.fd() < 0 ||
        connect(socket.fd(), upstream_.generic(), upstream_.length) != 0) {
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
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
    static_cast<void>(poll(entries_.data(), entries_.size(),
                           static_cast<int>(std::clamp<std::int64_t>(ms, 0, 1000))));
  }

  RelayOptions options_;
  Address upstream_;
  Socket socket_;
  std::vector<Client> clients_;
  std::vector<pollfd> entries_;
  std::uint64_t opened_ = 0;
  RelayCounts gone_;
  std::array<std::byte, 65'536> buffer_{};
};

}  // namespace

std::expected<std::unique_ptr<Relay>, std::string> Relay::open(const RelayOptions& options) {
  const auto upstream = resolve_place(options.upstream);
  if (!upstream) {
    return std::unexpected(upstream.error());
  }
  const auto at = resolve_literal(options.listen_address, options.listen_port);
  if (!at) {
    return std::unexpected("listening address '" + options.listen_address +
                           "': not an IPv4 or IPv6 address");
  }
  Socket socket = udp_socket(at->storage.ss_family);
  if (socket.fd() < 0 || bind(socket.fd(), at->generic(), at->length) != 0) {
    return std::unexpected("UDP port " + std::to_string(options.listen_port) + " at " +
                           options.listen_address + ": " + std::strerror(errno) +
                           "; close the program that uses it or take another port");
  }
  return std::make_unique<UdpRelay>(options, *upstream, std::move(socket));
}

}  // namespace stof::link

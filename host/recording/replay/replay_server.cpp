#include "host/recording/replay/replay_server.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <poll.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/frame/raw_packets.h"
#include "firmware/wire/messages/subscribe.h"
#include "firmware/wire/messages/subscribed.h"
#include "posix/poll.h"

namespace stof::recording {
namespace {

using wire::PacketType;
using wire::SubscribeResult;

constexpr int kSendBuffer = 4 << 20;
constexpr std::chrono::seconds kSlot{16};  // of a cookie: it is good in its own and the next one
constexpr std::chrono::milliseconds kLease{3000};
constexpr std::chrono::milliseconds kShortestLease{500};
constexpr std::chrono::milliseconds kLongestLease{10'000};
constexpr int kRequestsAtOnce = 256;

std::chrono::milliseconds granted(std::uint16_t lease_ms) {
  return lease_ms == 0
             ? kLease
             : std::clamp(std::chrono::milliseconds(lease_ms), kShortestLease, kLongestLease);
}

std::uint64_t slot_of(Time now) {
  return static_cast<std::uint64_t>(now.time_since_epoch() / kSlot);
}

}  // namespace

std::expected<ReplayServer, std::string> ReplayServer::open(const std::string& address,
                                                            std::uint16_t port) {
  const std::string where = address + " port " + std::to_string(port) + ": ";
  auto at = posix::resolve({.host = address, .port = port}, posix::Names::kAddressesOnly);
  if (!at) {
    return std::unexpected(where + "takes an address of this machine: " + at.error());
  }
  ReplayServer server;
  server.socket_ = posix::UdpSocket(at->front().family());
  if (const int error = server.socket_.is_open() ? server.socket_.bind(at->front()) : errno;
      error != 0) {
    return std::unexpected(where + std::strerror(error) +
                           ": give another --port, or an address of this machine to --bind");
  }
  server.socket_.set_buffer(posix::UdpSocket::Buffer::kSend, kSendBuffer);
  wire::fill_random(server.secret_);
  return server;
}

std::uint64_t ReplayServer::cookie_of(const posix::SocketAddress& peer, std::uint64_t slot) const {
  const std::string text = peer.text();
  std::array<std::byte, 8> when{};
  wire::put_u64(when, slot);
  const wire::Tag tag = wire::tag_of(secret_, {when, std::as_bytes(std::span(text))});
  return std::max<std::uint64_t>(wire::get_u64(std::span(tag).first<8>()), 1);
}

bool ReplayServer::serve(Time now) {
  wire::DatagramBuffer buffer;
  for (int i = 0; i < kRequestsAtOnce; ++i) {
    posix::SocketAddress from;
    const auto bytes = socket_.receive(buffer, &from);
    if (bytes) {
      take(std::span(buffer).first(std::min(*bytes, buffer.size())), from, now);
    } else if (!posix::answers_earlier(bytes.error())) {
      if (bytes.error() != EAGAIN && bytes.error() != EWOULDBLOCK && bytes.error() != EINTR) {
        return false;
      }
      break;
    }
  }
  std::erase_if(subscribers_, [now](const Subscriber& one) { return now >= one.until; });
  return true;
}

bool ReplayServer::serve_until(Time time) {
  for (;;) {
    const Time now = Time::clock::now();
    if (!serve(now)) {
      return false;
    }
    if (now >= time) {
      return true;
    }
    std::array<pollfd, 1> entries{{{.fd = socket_.fd(), .events = POLLIN, .revents = 0}}};
    static_cast<void>(posix::wait_for(entries, time - now));
  }
}

void ReplayServer::take(std::span<const std::byte> datagram, const posix::SocketAddress& from,
                        Time now) {
  const auto packet = wire::parse_packet(datagram);
  const bool begins = packet && packet->header.type == PacketType::kSubscribe;
  if (!packet || (!begins && packet->header.type != PacketType::kUnsubscribe)) {
    return;
  }
  const std::uint32_t meant = packet->header.origin.device_id;
  const auto asked = wire::decode_subscribe(packet->payload);
  if (!asked || (meant != 0 && meant != origin_.device_id)) {
    return;
  }
  const std::uint64_t slot = slot_of(now);
  const auto known = std::ranges::find(subscribers_, from, &Subscriber::address);
  wire::Subscribed answer{.request_id = asked->request_id, .cookie = cookie_of(from, slot)};
  if (asked->cookie != answer.cookie && asked->cookie != cookie_of(from, slot - 1)) {
    answer.result = SubscribeResult::kCookie;
  } else if (!begins) {
    answer.result = SubscribeResult::kEnded;
    if (known != subscribers_.end()) {
      subscribers_.erase(known);
    }
  } else if (known == subscribers_.end() && subscribers_.size() == kMostSubscribers) {
    answer.result = SubscribeResult::kFull;
  } else {
    const std::chrono::milliseconds lease = granted(asked->lease_ms);
    answer.result = (asked->raw.pictures & wire::kRawPictures) != 0 ? SubscribeResult::kRawDenied
                                                                    : SubscribeResult::kOk;
    answer.lease_ms = static_cast<std::uint16_t>(lease.count());
    if (known == subscribers_.end()) {
      subscribers_.push_back({.address = from, .until = now + lease});
      ++begun_;
    } else {
      known->until = std::max(known->until, now + lease);
    }
  }
  answer.subscribers = static_cast<std::uint8_t>(subscribers_.size());
  wire::DatagramBuffer buffer;
  wire::encode_subscribed(answer, wire::payload_space(buffer).first<wire::kSubscribedBytes>());
  const wire::Header header{.type = PacketType::kSubscribed,
                            .origin = origin_,
                            .frame = {.clock = wire::ClockState::kRecorded}};
  static_cast<void>(
      socket_.send_to(from, wire::seal_packet(header, wire::kSubscribedBytes, buffer)));
}

void ReplayServer::send(wire::Datagrams datagrams) {
  for (const Subscriber& one : subscribers_) {
    for (const std::span<const std::byte> datagram : datagrams) {
      static_cast<void>(socket_.send_to(one.address, datagram));
    }
  }
}

}  // namespace stof::recording

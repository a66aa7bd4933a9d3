#include "tests/campaign/attack.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "firmware/wire/messages/subscribe.h"
#include "firmware/wire/packet.h"
#include "tests/campaign/robot.h"

namespace stof::campaign {
namespace {

constexpr hal::Duration kBetweenFlood = std::chrono::microseconds(50);  // 20,000 a second
constexpr hal::Duration kBetweenLies = std::chrono::milliseconds(10);
constexpr int kRequestsAnAct = 100;

std::vector<std::byte> sealed(const wire::Header& header, std::span<const std::byte> payload) {
  wire::DatagramBuffer buffer;
  std::ranges::copy(payload, wire::payload_space(buffer).begin());
  const std::span<const std::byte> datagram = wire::seal_packet(header, payload.size(), buffer);
  return {datagram.begin(), datagram.end()};
}

}  // namespace

Attacker::Bytes Attacker::junk() {
  Bytes bytes(static_cast<std::size_t>(random_.between(0, 200)));
  for (std::byte& byte : bytes) {
    byte = static_cast<std::byte>(random_.next());
  }
  return bytes;
}

// Of the same sensor and session, with numbers that no sensor can have counted.
Attacker::Bytes Attacker::changed_header(const Bytes& datagram) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet) {
    return junk();
  }
  wire::Header header = packet->header;
  constexpr std::uint32_t kFar = 1U << 30;
  if (random_.between(0, 1) == 0) {
    header.frame.number += kFar;
  }
  header.frame.freshness += kFar;
  switch (random_.between(0, 3)) {
    case 0: {
      std::array<std::byte, wire::kHealthReportBytes> payload{};
      wire::encode_health_report({.uptime_ms = std::numeric_limits<std::uint64_t>::max()}, payload);
      header = {.type = wire::PacketType::kHealth, .origin = header.origin, .frame = header.frame};
      return sealed(header, payload);
    }
    case 1: {
      std::array<std::byte, wire::kEventReportBytes> payload{};
      wire::encode_event_report(
          {.sequence = kFar + static_cast<std::uint32_t>(random_.next() % 99)}, payload);
      header = {.type = wire::PacketType::kEvent, .origin = header.origin, .frame = header.frame};
      return sealed(header, payload);
    }
    default:
      return sealed(header, packet->payload);
  }
}

Attacker::Bytes Attacker::forged_request() {
  std::array<std::byte, wire::kSubscribeBytes> payload{};
  wire::encode_subscribe({.request_id = static_cast<std::uint32_t>(random_.next()),
                          .lease_ms = 500,
                          .cookie = random_.next()},
                         payload);
  const auto type =
      random_.between(0, 1) == 0 ? wire::PacketType::kSubscribe : wire::PacketType::kUnsubscribe;
  return sealed({.type = type}, payload);
}

void Attacker::flood_robot(Network& network, hal::Time from, hal::Time until) {
  if (captured_.empty()) {
    captured_.assign(network.overheard().begin(), network.overheard().end());
  }
  for (hal::Time at = from; at < until; at += kBetweenFlood) {
    const bool replay = attack_ == Attack::kStale && !captured_.empty();
    network.inject({.at = client_time(at),
                    .bytes = replay ? captured_[random_.next() % captured_.size()] : junk()});
  }
}

void Attacker::lie(Network& network, hal::Time at) {
  if (network.overheard().empty()) {
    return;
  }
  const Bytes& newest = network.overheard().back();
  if (attack_ == Attack::kLies) {
    network.inject({.at = client_time(at), .bytes = changed_header(newest)});
    return;
  }
  const auto packet = wire::parse_packet(newest);
  if (done_ || !packet || !wire::part_of_frame(packet->header.type)) {
    return;
  }
  wire::Header header = packet->header;
  header.origin.session_id ^= 0x5A5A5A5A;
  header.count = 2;  // never whole
  header.index = 1;
  network.inject({.at = client_time(at), .bytes = sealed(header, packet->payload)});
  done_ = true;
}

void Attacker::ask(Network& network) {
  for (int i = 0; i < kRequestsAnAct; ++i) {
    if (attack_ == Attack::kForgedRequests) {
      network.to_sensor(forged_request(), Robot::peer());
      continue;
    }
    Bytes request = forged_request();
    request[static_cast<std::size_t>(random_.between(0, static_cast<int>(request.size()) - 1))] ^=
        static_cast<std::byte>(random_.between(1, 255));
    hal::Peer from = Robot::peer();
    from.address[15] = static_cast<std::uint8_t>(random_.between(3, 250));
    network.to_sensor(request, from);
  }
}

void Attacker::act(Network& network, hal::Time from, hal::Time until) {
  from = std::max(from, span_.begin);
  until = std::min(until, span_.end);
  if (attack_ == Attack::kNone || from >= until) {
    return;
  }
  switch (attack_) {
    case Attack::kJunk:
    case Attack::kStale:
      flood_robot(network, from, until);
      break;
    case Attack::kLies:
    case Attack::kOtherSession:
      for (hal::Time at = from; at < until; at += kBetweenLies) {
        lie(network, at);
      }
      break;
    case Attack::kForgedRequests:
    case Attack::kRequestFlood:
      ask(network);
      break;
    case Attack::kUnreachable:
      network.refuse(Robot::peer());
      break;
    case Attack::kNone:
      break;
  }
}

}  // namespace stof::campaign

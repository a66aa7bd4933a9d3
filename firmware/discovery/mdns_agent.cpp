#include "firmware/discovery/mdns_agent.h"

#include <algorithm>
#include <span>

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kLook = 2s;
constexpr unsigned kMostReads = 32;  // of one tick
constexpr unsigned kMostSends = 32;

}  // namespace

void MdnsAgent::send(const Responder::Datagram& datagram) noexcept {
  const std::span<const std::byte> one = datagram.bytes;
  std::size_t sent = 0;
  // What is lost here is asked for again.
  static_cast<void>(port_.send(datagram.to, std::span(&one, 1), sent));
}

void MdnsAgent::send_due(hal::Time now) noexcept {
  for (unsigned i = 0; i < kMostSends; ++i) {
    const std::optional<Responder::Datagram> datagram = responder_.next(now);
    if (!datagram) {
      return;
    }
    send(*datagram);
  }
}

void MdnsAgent::tick(hal::Time now) noexcept {
  if (now >= look_due_) {
    look_due_ = now + kLook;
    const auto found = std::span(addresses_).first(network_.addresses(addresses_));
    port_.join(found);
    responder_.set_addresses(found, now);
  }
  for (unsigned i = 0; i < kMostReads; ++i) {
    const Result<hal::Received> received = port_.receive(buffer_, hal::Duration::zero());
    if (!received) {
      break;
    }
    const auto message = std::span(buffer_).first(std::min(received->bytes, buffer_.size()));
    if (const auto answer = responder_.take(message, received->from, now)) {
      send(*answer);
    }
  }
  send_due(now);
}

void MdnsAgent::stop(hal::Time now) noexcept {
  responder_.stop(now);
  send_due(now);
}

}  // namespace stof::firmware

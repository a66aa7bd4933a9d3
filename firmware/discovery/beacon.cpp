#include "firmware/discovery/beacon.h"

#include <algorithm>
#include <span>

namespace stof::firmware {

std::span<const std::byte> seal_announce(const wire::Announce& announce, const wire::Origin& origin,
                                         const wire::FrameStamp& stamp,
                                         wire::DatagramBuffer& buffer) noexcept {
  wire::encode_announce(announce, wire::payload_space(buffer).first<wire::kAnnounceBytes>());
  const wire::Header header{.type = wire::PacketType::kAnnounce, .origin = origin, .frame = stamp};
  return wire::seal_packet(header, wire::kAnnounceBytes, buffer);
}

void Beacon::set(const wire::Announce& announce, const wire::Origin& origin,
                 const wire::FrameStamp& stamp) noexcept {
  contents_ = Contents{.announce = announce, .origin = origin, .stamp = stamp};
  contents_->announce.request_id = 0;
}

void Beacon::tick(hal::Time now) noexcept {
  if (port_ == nullptr || !contents_ || (due_ && now < *due_)) {
    return;
  }
  due_ = now + kPeriod;
  const std::span<const std::byte> packet =
      seal_announce(contents_->announce, contents_->origin, contents_->stamp, buffer_);
  const auto send_to = [&](const hal::Peer& peer) {
    std::size_t sent = 0;
    // Nobody to hear it is no error.
    static_cast<void>(port_->send(peer, std::span(&packet, 1), sent));
  };
  constexpr std::array<std::uint8_t, 16> kNone{};
  constexpr std::array<std::uint8_t, 16> kLoopback = hal::from_ipv4(127, 255, 255, 255);
  const auto found = std::span(addresses_).first(network_.addresses(addresses_));
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto earlier = found.first(i);
    const bool again = std::ranges::any_of(earlier, [&](const hal::InterfaceAddress& other) {
      return other.broadcast == found[i].broadcast;
    });
    if (found[i].broadcast == kNone) {
      continue;
    }
    if (!again) {
      send_to({.address = found[i].broadcast, .port = kLinkPort});
    }
    if (found[i].broadcast != kLoopback) {
      hal::Peer all = all_of_link(found[i].interface);
      all.own = found[i].address;
      send_to(all);
    }
  }
}

}  // namespace stof::firmware

#include "firmware/discovery/mdns.h"

#include <algorithm>

namespace stof::firmware {
namespace {

namespace dns = wire::dns;
using namespace std::chrono_literals;
using Section = dns::Writer::Section;

constexpr unsigned kProbes = 3;
constexpr hal::Duration kProbeGap = 250ms;
constexpr unsigned kAnnouncements = 2;
constexpr hal::Duration kSecond = 1s;  // between announcements, and between answers to all
constexpr unsigned kManyConflicts = 15;
constexpr hal::Duration kConflictWindow = 10s;
constexpr hal::Duration kConflictPause = 5s;
constexpr unsigned kMostSuffix = 9999;

constexpr RecordSet kAll = kServicesPtr | kInstancePtr | kSrv | kTxt | kA | kAaaa | kHostNsec;
// Not the list of services: others offer this one, too.
constexpr RecordSet kLeaving = kInstancePtr | kSrv | kTxt | kA | kAaaa;

constexpr auto kGroup4 = hal::from_ipv4(224, 0, 0, 251);
constexpr std::array<std::uint8_t, 16> kGroup6{0xff, 0x02, 0, 0, 0, 0, 0, 0,
                                               0,    0,    0, 0, 0, 0, 0, 0xfb};

hal::Peer group_of(std::uint32_t interface, bool ipv6) noexcept {
  return {.address = ipv6 ? kGroup6 : kGroup4, .port = Responder::kPort, .scope = interface};
}

bool same_names(const Service& a, const Service& b) noexcept {
  return a.announce.serial == b.announce.serial && a.announce.name == b.announce.name &&
         a.announce.version == b.announce.version && a.announce.board == b.announce.board &&
         a.announce.port == b.announce.port && a.device_id == b.device_id;
}

// Whether the first `bits` are alike.
bool same_prefix(const std::array<std::uint8_t, 16>& a, const std::array<std::uint8_t, 16>& b,
                 unsigned bits) noexcept {
  for (unsigned i = 0; i < 16 && 8 * i < bits; ++i) {
    const unsigned rest = std::min(8U, bits - 8 * i);
    if (((a[i] ^ b[i]) >> (8 - rest)) != 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

Responder::Responder(const Service& service, std::uint32_t seed) noexcept
    : service_(service), records_(service, suffix_), random_(seed | 1) {}

std::uint32_t Responder::random(std::uint32_t below) noexcept {
  random_ ^= random_ << 13;  // xorshift: Marsaglia 2003
  random_ ^= random_ >> 17;
  random_ ^= random_ << 5;
  return random_ % below;
}

void Responder::enter(Phase phase, hal::Time due) noexcept {
  phase_ = phase;
  steps_ = 0;
  step_due_ = due;
  step_link_ = 0;
  for (Link& link : links_) {
    link.pending = 0;
  }
}

void Responder::find_links() noexcept {
  link_count_ = 0;
  for (const hal::InterfaceAddress& address : std::span(addresses_).first(address_count_)) {
    const bool ipv6 = !hal::is_ipv4(address.address);
    const auto known = std::span(links_).first(link_count_);
    const bool is_known = std::ranges::any_of(known, [&](const Link& link) {
      return link.interface == address.interface && link.ipv6 == ipv6;
    });
    if (address.multicast && !is_known && link_count_ < kMostLinks) {
      links_[link_count_++] = Link{.interface = address.interface, .ipv6 = ipv6};
    }
  }
}

void Responder::set_addresses(std::span<const hal::InterfaceAddress> addresses,
                              hal::Time now) noexcept {
  addresses = addresses.first(std::min(addresses.size(), kMostAddresses));
  const auto current = std::span(addresses_).first(address_count_);
  if (std::ranges::equal(addresses, current) && phase_ != Phase::kStopped) {
    return;
  }
  std::ranges::copy(addresses, addresses_.begin());
  address_count_ = addresses.size();
  records_.set_addresses(std::span(addresses_).first(address_count_));
  find_links();
  if (phase_ != Phase::kGoodbye) {
    enter(Phase::kProbe, now + std::chrono::milliseconds(random(250)));
  }
}

void Responder::set_service(const Service& service, hal::Time now) noexcept {
  if (same_names(service, replacement_ ? *replacement_ : service_)) {
    return;
  }
  replacement_ = service;
  if (phase_ != Phase::kGoodbye) {
    enter(Phase::kGoodbye, now);
  }
}

void Responder::stop(hal::Time now) noexcept {
  replacement_.reset();
  enter(phase_ == Phase::kProbe || phase_ == Phase::kStopped ? Phase::kStopped : Phase::kGoodbye,
        now);
}

Responder::Link* Responder::link_of(const hal::Peer& peer) noexcept {
  const auto links = std::span(links_).first(link_count_);
  const bool ipv6 = !hal::is_ipv4(peer.address);
  const auto found = std::ranges::find_if(
      links, [&](const Link& link) { return link.interface == peer.scope && link.ipv6 == ipv6; });
  return found == links.end() ? nullptr : &*found;
}

// RFC 6762 section 11. It also keeps this from being an amplifier of the wide network.
bool Responder::on_link(const hal::Peer& peer) const noexcept {
  const auto addresses = std::span(addresses_).first(address_count_);
  return std::ranges::any_of(addresses, [&](const hal::InterfaceAddress& own) {
    return own.interface == peer.scope && same_prefix(own.address, peer.address, own.prefix_bits);
  });
}

// Whoever has the name already keeps it; where both have it, the probes decide.
void Responder::lose(hal::Time now) noexcept {
  if (now - conflicts_since_ > kConflictWindow) {
    conflicts_since_ = now;
    conflicts_ = 0;
  }
  ++conflicts_;
  if (phase_ == Phase::kProbe) {
    suffix_ = suffix_ < kMostSuffix ? suffix_ + 1 : 2;
    records_ = Records(service_, suffix_);
    records_.set_addresses(std::span(addresses_).first(address_count_));
  }
  enter(Phase::kProbe, conflicts_ > kManyConflicts ? now + kConflictPause : now);
}

void Responder::next_step(hal::Time now) noexcept {
  step_link_ = 0;
  ++steps_;
  if (phase_ == Phase::kProbe) {
    step_due_ = now + kProbeGap;
    if (steps_ == kProbes) {
      enter(Phase::kAnnounce, step_due_);
    }
  } else if (phase_ == Phase::kAnnounce) {
    step_due_ = now + kSecond;
    if (steps_ == kAnnouncements) {
      phase_ = Phase::kSteady;
    }
  } else if (replacement_) {
    service_ = *replacement_;
    replacement_.reset();
    suffix_ = 1;
    records_ = Records(service_, suffix_);
    records_.set_addresses(std::span(addresses_).first(address_count_));
    enter(Phase::kProbe, now);
  } else {
    enter(Phase::kStopped, now);
  }
}

std::optional<Responder::Datagram> Responder::step(const Link& link) noexcept {
  const bool probe = phase_ == Phase::kProbe;
  dns::Writer writer(
      buffer_, 0,
      probe ? std::uint16_t{0} : static_cast<std::uint16_t>(dns::kResponse | dns::kAuthoritative));
  if (probe) {
    records_.write_probe(writer, link.interface);
  } else if (phase_ == Phase::kAnnounce) {
    const RecordSet negative =
        records_.additionals(kSrv, link.interface) & kHostNsec;  // only where a kind is missing
    records_.write(writer, static_cast<RecordSet>((kAll & ~kHostNsec) | negative), Section::kAnswer,
                   link.interface, Tone::kMulticast);
  } else {
    records_.write(writer, kLeaving, Section::kAnswer, link.interface, Tone::kGoodbye);
  }
  return Datagram{.to = group_of(link.interface, link.ipv6), .bytes = writer.message()};
}

std::optional<Responder::Datagram> Responder::flush(Link& link, hal::Time now) noexcept {
  RecordSet answers = link.pending;
  link.pending = 0;
  link.more_from.reset();
  for (std::size_t bit = 0; bit < kRecordKinds; ++bit) {
    const RecordSet kind = static_cast<RecordSet>(answers & (1U << bit));
    if (kind != 0 && link.sent[bit] && now - *link.sent[bit] < kSecond) {
      answers = static_cast<RecordSet>(answers & ~kind);
    } else if (kind != 0) {
      link.sent[bit] = now;
    }
  }
  if (answers == 0) {
    return std::nullopt;
  }
  dns::Writer writer(buffer_, 0, dns::kResponse | dns::kAuthoritative);
  records_.write(writer, answers, Section::kAnswer, link.interface, Tone::kMulticast);
  records_.write(writer, records_.additionals(answers, link.interface), Section::kAdditional,
                 link.interface, Tone::kMulticast);
  return Datagram{.to = group_of(link.interface, link.ipv6), .bytes = writer.message()};
}

std::optional<Responder::Datagram> Responder::next(hal::Time now) noexcept {
  while (phase_ != Phase::kSteady && phase_ != Phase::kStopped && now >= step_due_) {
    if (step_link_ < link_count_) {
      return step(links_[step_link_++]);
    }
    next_step(now);
  }
  for (Link& link : std::span(links_).first(link_count_)) {
    if (link.pending != 0 && now >= link.due) {
      if (const std::optional<Datagram> datagram = flush(link, now)) {
        return datagram;
      }
    }
  }
  return std::nullopt;
}

}  // namespace stof::firmware

#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "firmware/discovery/mdns.h"
#include "firmware/wire/dns.h"

// A responder on one link, and what it says.
namespace stof::firmware::test {

namespace dns = wire::dns;
using dns::Type;

inline constexpr std::uint32_t kEthernet = 2;
inline constexpr auto kOwn4 = hal::from_ipv4(192, 0, 2, 2);
inline constexpr auto kPeer4 = hal::from_ipv4(192, 0, 2, 9);
inline constexpr hal::Peer kNeighbour{.address = kPeer4, .port = 5353, .scope = kEthernet};
inline constexpr hal::Peer kLegacyPeer{.address = kPeer4, .port = 40000, .scope = kEthernet};
inline constexpr hal::InterfaceAddress kEthernet4{
    .interface = kEthernet, .address = kOwn4, .prefix_bits = 96 + 24, .multicast = true};

template <std::size_t kSize>
void put_text(std::array<char, kSize>& out, std::string_view text) {
  std::ranges::copy(text, out.begin());
}

inline Service some_service() {
  Service service{.announce = {.port = 7560}, .device_id = 0x0a0b0c0d};
  put_text(service.announce.serial, "A17");
  put_text(service.announce.name, "front");
  put_text(service.announce.version, "0.1.0");
  put_text(service.announce.board, "emu");
  return service;
}

inline const dns::Name kService{"_stof", "_udp", "local"};
inline const dns::Name kServices{"_services", "_dns-sd", "_udp", "local"};
inline const dns::Name kInstance{"front (A17)", "_stof", "_udp", "local"};
inline const dns::Name kHost{"stof-a17", "local"};

struct Heard {
  hal::Time at;
  hal::Peer to;
  dns::Header header;
  std::vector<dns::Question> questions;
  std::vector<dns::Record> records;  // of all sections
  std::vector<std::byte> bytes;

  int count(Type type) const {
    return static_cast<int>(std::ranges::count(records, type, &dns::Record::type));
  }
  const dns::Record* find(Type type) const {
    const auto found = std::ranges::find(records, type, &dns::Record::type);
    return found == records.end() ? nullptr : &*found;
  }
};

inline Heard hear(const Responder::Datagram& datagram, hal::Time at) {
  Heard heard{.at = at,
              .to = datagram.to,
              .header = {},
              .questions = {},
              .records = {},
              .bytes = {datagram.bytes.begin(), datagram.bytes.end()}};
  dns::Reader reader(heard.bytes);
  heard.header = reader.header().value();
  for (int i = 0; i < heard.header.questions; ++i) {
    heard.questions.push_back(reader.question().value());
  }
  const int records = heard.header.answers + heard.header.authorities + heard.header.additionals;
  for (int i = 0; i < records; ++i) {
    heard.records.push_back(reader.record().value());
  }
  return heard;
}

// A message in the making.
class Message {
 public:
  explicit Message(std::uint16_t flags = 0, std::uint16_t id = 0) : writer_(space_, id, flags) {}
  Message& ask(const dns::Name& name, Type type, std::uint16_t klass = dns::kInternet) {
    static_cast<void>(writer_.question(name, type, klass));
    return *this;
  }
  Message& pointer(const dns::Name& name, const dns::Name& to, std::uint32_t ttl_s) {
    writer_.begin_record(name, Type::kPtr, dns::kInternet, ttl_s);
    writer_.data_name(to);
    static_cast<void>(writer_.finish(dns::Writer::Section::kAnswer));
    return *this;
  }
  Message& srv(const dns::Name& name, std::uint16_t port, const dns::Name& host,
               std::uint32_t ttl_s = 120,
               dns::Writer::Section section = dns::Writer::Section::kAnswer) {
    writer_.begin_record(name, Type::kSrv, dns::kInternet | dns::kTopBit, ttl_s);
    writer_.data_u16(0);
    writer_.data_u16(0);
    writer_.data_u16(port);
    writer_.data_name(host);
    static_cast<void>(writer_.finish(section));
    return *this;
  }
  Message& address(const dns::Name& name, const std::array<std::uint8_t, 16>& address,
                   dns::Writer::Section section = dns::Writer::Section::kAnswer) {
    writer_.begin_record(name, Type::kA, dns::kInternet | dns::kTopBit, 120);
    writer_.data(std::as_bytes(std::span(address)).last(4));
    static_cast<void>(writer_.finish(section));
    return *this;
  }
  // padded: filled up to so many, so that there is room for a long answer.
  std::vector<std::byte> bytes(std::size_t padded = 0) {
    const auto message = writer_.message();
    std::vector<std::byte> all(message.begin(), message.end());
    all.resize(std::max(all.size(), padded));
    return all;
  }

 private:
  std::array<std::byte, hal::kMaxDatagram> space_{};
  dns::Writer writer_;
};

class Bench {
 public:
  explicit Bench(std::vector<hal::InterfaceAddress> addresses = {kEthernet4})
      : responder(some_service(), 1), now(std::chrono::seconds(100)) {
    responder.set_addresses(addresses, now);
  }

  // Everything that is sent to all in this time.
  std::vector<Heard> run(hal::Duration time) {
    std::vector<Heard> heard;
    for (const hal::Time end = now + time; now < end; now += std::chrono::milliseconds(10)) {
      while (const auto datagram = responder.next(now)) {
        heard.push_back(hear(*datagram, now));
      }
    }
    return heard;
  }
  void settle() { static_cast<void>(run(std::chrono::seconds(4))); }

  std::optional<Heard> take(const std::vector<std::byte>& message,
                            const hal::Peer& from = kNeighbour) {
    const auto datagram = responder.take(message, from, now);
    return datagram ? std::optional(hear(*datagram, now)) : std::nullopt;
  }

  Responder responder;
  hal::Time now;
};

}  // namespace stof::firmware::test

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/wire/dns.h"
#include "firmware/wire/messages/announce.h"
#include "hal/network_interfaces.h"

// The sensor's names on the local link (RFC 6763), as records of DNS:
//   _services._dns-sd._udp.local  PTR   _stof._udp.local
//   _stof._udp.local              PTR   <name> (<serial>)._stof._udp.local
//   <instance>                    SRV   port, stof-<serial>.local
//   <instance>                    TXT   txtvers serial name version board id path
//   stof-<serial>.local           A, AAAA: the addresses of the interface that is asked
namespace stof::firmware {

struct Service {
  wire::Announce announce;      // serial, name, version, board, port; the rest is not looked at
  std::uint32_t device_id = 0;  // as in the packets' headers
};

// Sets of records.
using RecordSet = std::uint8_t;
inline constexpr RecordSet kServicesPtr = 1 << 0;
inline constexpr RecordSet kInstancePtr = 1 << 1;
inline constexpr RecordSet kSrv = 1 << 2;
inline constexpr RecordSet kTxt = 1 << 3;
inline constexpr RecordSet kA = 1 << 4;
inline constexpr RecordSet kAaaa = 1 << 5;
inline constexpr RecordSet kInstanceNsec = 1 << 6;  // "of this name there are SRV and TXT only"
inline constexpr RecordSet kHostNsec = 1 << 7;
inline constexpr std::size_t kRecordKinds = 8;
// Others may have records of the same name.
inline constexpr RecordSet kShared = kServicesPtr | kInstancePtr;

// Text up to its first 0.
template <std::size_t kSize>
constexpr std::string_view text_of(const std::array<char, kSize>& text) noexcept {
  return std::string_view(text.data(), kSize)
      .substr(0, std::string_view(text.data(), kSize).find('\0'));
}

// Seconds that a record may be kept: RFC 6762 section 10.
constexpr std::uint32_t life_s(RecordSet kind) noexcept {
  return (kind & (kServicesPtr | kInstancePtr | kTxt)) != 0 ? 4500 : 120;
}

enum class ResponseKind : std::uint8_t {
  kMulticast,
  kLegacy,   // to whoever does not know mDNS: short lives, no claim to be the only one
  kGoodbye,  // lives of 0
};

class Records {
 public:
  // suffix: 1: none; above, "-2" and so on behind both names.
  Records(const Service& service, unsigned suffix) noexcept;

  // At least as long as the one given; used until the next call.
  void set_addresses(std::span<const hal::InterfaceAddress> addresses) noexcept {
    addresses_ = addresses;
  }

  // The answers to a question that came by an interface.
  RecordSet answers(const wire::dns::Question& question, std::uint32_t interface) const noexcept;
  // The records that should go with the answers, without these.
  RecordSet additionals(RecordSet answers, std::uint32_t interface) const noexcept;
  // Which of ours a record is, its data alike and its life at least half of ours; an address only
  // where the interface has no other of its kind. 0: none.
  RecordSet known(const wire::dns::Reader& message, const wire::dns::Record& record,
                  std::uint32_t interface) const noexcept;

  enum class Conflict : std::uint8_t { kNone, kBelow, kAbove };
  // Whether a record claims one of our names for something else, and how its data compare with ours
  // (RFC 6762 section 8.2).
  Conflict conflict(const wire::dns::Reader& message,
                    const wire::dns::Record& record) const noexcept;

  void write(wire::dns::Writer& writer, RecordSet set, wire::dns::Writer::Section section,
             std::uint32_t interface, ResponseKind response) const noexcept;
  // Questions for our names, with what we are going to claim.
  void write_probe(wire::dns::Writer& writer, std::uint32_t interface) const noexcept;

  const wire::dns::Name& instance() const noexcept { return instance_; }
  const wire::dns::Name& host() const noexcept { return host_; }

 private:
  void write_one(wire::dns::Writer& writer, RecordSet kind, std::uint16_t klass,
                 std::uint32_t ttl_s) const noexcept;
  void write_addresses(wire::dns::Writer& writer, RecordSet kind,
                       wire::dns::Writer::Section section, std::uint32_t interface,
                       std::uint16_t klass, std::uint32_t ttl_s) const noexcept;
  void write_txt(wire::dns::Writer& writer) const noexcept;
  RecordSet address_kinds(std::uint32_t interface) const noexcept;
  std::size_t count(RecordSet kind, std::uint32_t interface) const noexcept;
  Conflict compare_srv(const wire::dns::Reader& message,
                       const wire::dns::Record& record) const noexcept;
  Conflict compare_address(const wire::dns::Record& record) const noexcept;

  Service service_;
  wire::dns::Name services_;
  wire::dns::Name type_;
  wire::dns::Name instance_;
  wire::dns::Name host_;
  std::span<const hal::InterfaceAddress> addresses_;
};

}  // namespace stof::firmware

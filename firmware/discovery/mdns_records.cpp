#include "firmware/discovery/mdns_records.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace stof::firmware {
namespace {

namespace dns = wire::dns;
using dns::Type;

constexpr std::uint32_t kLegacyLifeSeconds = 10;
constexpr std::string_view kTop = "local";

// Text that grows in place; what does not fit is left out.
class Label {
 public:
  void add(std::string_view text) noexcept {
    const std::size_t bytes = std::min(text.size(), text_.size() - size_);
    std::ranges::copy(text.substr(0, bytes), text_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += bytes;
  }
  void add_suffix(unsigned suffix) noexcept {
    if (suffix > 1) {
      std::array<char, 11> digits{'-'};
      const auto [end, error] =
          std::to_chars(digits.data() + 1, digits.data() + digits.size(), suffix);
      add({digits.data(), static_cast<std::size_t>(end - digits.data())});
    }
  }
  std::string_view view() const noexcept { return {text_.data(), size_}; }

 private:
  std::array<char, 63> text_{};
  std::size_t size_ = 0;
};

// What a host's name may have: small letters, digits, hyphens.
char host_character(char c) noexcept {
  if (c >= 'A' && c <= 'Z') {
    return static_cast<char>(c - 'A' + 'a');
  }
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? c : '-';
}

Label host_label(std::string_view serial, unsigned suffix) noexcept {
  Label label;
  label.add("stof-");
  for (const char c : serial) {
    const char allowed = host_character(c);
    label.add({&allowed, 1});
  }
  label.add_suffix(suffix);
  return label;
}

Label instance_label(const wire::Announce& announce, unsigned suffix) noexcept {
  Label label;
  const std::string_view name = text_of(announce.name);
  label.add(name.empty() ? "stof" : name);
  label.add(" (");
  label.add(text_of(announce.serial));
  label.add(")");
  label.add_suffix(suffix);
  return label;
}

std::uint16_t klass_of(RecordSet kind, ResponseKind response) noexcept {
  const bool ours_alone = (kind & kShared) == 0 && response != ResponseKind::kLegacy;
  return static_cast<std::uint16_t>(dns::kInternet | (ours_alone ? dns::kTopBit : 0));
}

// The data of the address' record, and which it is.
std::span<const std::byte> record_data(const hal::InterfaceAddress& address) noexcept {
  const auto all = std::as_bytes(std::span(address.address));
  return hal::is_ipv4(address.address) ? all.last(4) : all;
}

RecordSet record_kind(const hal::InterfaceAddress& address) noexcept {
  return hal::is_ipv4(address.address) ? kA : kAaaa;
}

}  // namespace

Records::Records(const Service& service, unsigned suffix) noexcept
    : service_(service),
      services_{"_services", "_dns-sd", "_udp", kTop},
      type_{"_stof", "_udp", kTop},
      instance_{instance_label(service.announce, suffix).view(), "_stof", "_udp", kTop},
      host_{host_label(text_of(service.announce.serial), suffix).view(), kTop} {}

std::size_t Records::count(RecordSet kind, std::uint32_t interface) const noexcept {
  return static_cast<std::size_t>(
      std::ranges::count_if(addresses_, [&](const hal::InterfaceAddress& address) {
        return address.interface == interface && record_kind(address) == kind;
      }));
}

RecordSet Records::address_kinds(std::uint32_t interface) const noexcept {
  return static_cast<RecordSet>((count(kA, interface) > 0 ? kA : 0) |
                                (count(kAaaa, interface) > 0 ? kAaaa : 0));
}

RecordSet Records::answers(const dns::Question& question, std::uint32_t interface) const noexcept {
  const int klass = question.klass & ~dns::kTopBit;
  if (klass != dns::kInternet && klass != dns::kAnyClass) {
    return 0;
  }
  const bool any = question.type == Type::kAny;
  if (any || question.type == Type::kPtr) {
    if (question.name == services_) {
      return kServicesPtr;
    }
    if (question.name == type_) {
      return kInstancePtr;
    }
  }
  RecordSet has = 0;
  RecordSet none = 0;
  if (question.name == instance_) {
    has = kSrv | kTxt;
    none = kInstanceNsec;
  } else if (question.name == host_) {
    has = address_kinds(interface);
    none = kHostNsec;
  }
  RecordSet asked = any ? has : RecordSet{0};
  switch (question.type) {
    case Type::kSrv:
      asked = kSrv;
      break;
    case Type::kTxt:
      asked = kTxt;
      break;
    case Type::kA:
      asked = kA;
      break;
    case Type::kAaaa:
      asked = kAaaa;
      break;
    default:
      break;
  }
  asked &= has;
  return asked != 0 ? asked : none;
}

RecordSet Records::additionals(RecordSet answers, std::uint32_t interface) const noexcept {
  RecordSet more = 0;
  if ((answers & kInstancePtr) != 0) {
    more |= kSrv | kTxt;
  }
  if (((answers | more) & (kSrv | kA | kAaaa)) != 0) {
    const RecordSet kinds = address_kinds(interface);
    more |= kinds;
    more |= kinds != (kA | kAaaa) ? kHostNsec : RecordSet{0};
  }
  return static_cast<RecordSet>(more & ~answers);
}

void Records::write_txt(dns::Writer& writer) const noexcept {
  std::array<char, 8> id{};
  for (std::size_t i = 0; i < id.size(); ++i) {
    id[i] = "0123456789abcdef"[(service_.device_id >> (4 * (7 - i))) & 15U];
  }
  const wire::Announce& announce = service_.announce;
  writer.data_text("txtvers", "1");
  writer.data_text("serial", text_of(announce.serial));
  writer.data_text("name", text_of(announce.name));
  writer.data_text("version", text_of(announce.version));
  writer.data_text("board", text_of(announce.board));
  writer.data_text("id", {id.data(), id.size()});
  writer.data_text("path", "/");
}

void Records::write_one(dns::Writer& writer, RecordSet kind, std::uint16_t klass,
                        std::uint32_t ttl_s) const noexcept {
  // RFC 4034 section 4.1.2: window 0, its length, bit k of it (from the left): type k.
  constexpr std::array<std::byte, 7> kInstanceTypes{std::byte{0},   std::byte{5},    std::byte{0},
                                                    std::byte{0},   std::byte{0x80}, std::byte{0},
                                                    std::byte{0x40}};  // 16 TXT, 33 SRV
  switch (kind) {
    case kServicesPtr:
      writer.begin_record(services_, Type::kPtr, klass, ttl_s);
      writer.data_name(type_);
      break;
    case kInstancePtr:
      writer.begin_record(type_, Type::kPtr, klass, ttl_s);
      writer.data_name(instance_);
      break;
    case kSrv:
      writer.begin_record(instance_, Type::kSrv, klass, ttl_s);
      writer.data_u16(0);
      writer.data_u16(0);
      writer.data_u16(service_.announce.port);
      writer.data_name(host_);
      break;
    case kTxt:
      writer.begin_record(instance_, Type::kTxt, klass, ttl_s);
      write_txt(writer);
      break;
    default:  // kInstanceNsec
      writer.begin_record(instance_, Type::kNsec, klass, ttl_s);
      writer.data_name(instance_);
      writer.data(kInstanceTypes);
      break;
  }
}

void Records::write_addresses(dns::Writer& writer, RecordSet kind, dns::Writer::Section section,
                              std::uint32_t interface, std::uint16_t klass,
                              std::uint32_t ttl_s) const noexcept {
  for (const hal::InterfaceAddress& address : addresses_) {
    if (address.interface == interface && record_kind(address) == kind) {
      writer.begin_record(host_, kind == kA ? Type::kA : Type::kAaaa, klass, ttl_s);
      writer.data(record_data(address));
      static_cast<void>(writer.finish(section));
    }
  }
}

void Records::write(dns::Writer& writer, RecordSet set, dns::Writer::Section section,
                    std::uint32_t interface, ResponseKind response) const noexcept {
  for (unsigned bit = 0; bit < kRecordKinds; ++bit) {
    const RecordSet kind = static_cast<RecordSet>(set & (1U << bit));
    if (kind == 0) {
      continue;
    }
    std::uint32_t ttl_s = response == ResponseKind::kGoodbye ? 0 : life_s(kind);
    ttl_s = response == ResponseKind::kLegacy ? std::min(ttl_s, kLegacyLifeSeconds) : ttl_s;
    const std::uint16_t klass = klass_of(kind, response);
    if ((kind & (kA | kAaaa)) != 0) {
      write_addresses(writer, kind, section, interface, klass, ttl_s);
      continue;
    }
    if (kind == kHostNsec) {
      const RecordSet has = address_kinds(interface);
      // Bits 1 (A) and 28 (AAAA).
      const std::array<std::byte, 6> types{
          std::byte{0}, std::byte{4}, (has & kA) != 0 ? std::byte{0x40} : std::byte{0},
          std::byte{0}, std::byte{0}, (has & kAaaa) != 0 ? std::byte{0x08} : std::byte{0}};
      writer.begin_record(host_, Type::kNsec, klass, ttl_s);
      writer.data_name(host_);
      writer.data(types);
    } else {
      write_one(writer, kind, klass, ttl_s);
    }
    static_cast<void>(writer.finish(section));
  }
}

void Records::write_probe(dns::Writer& writer, std::uint32_t interface) const noexcept {
  // Answered to all: the port may be shared, and an answer to one reach another program.
  static_cast<void>(writer.question(instance_, Type::kAny, dns::kInternet));
  static_cast<void>(writer.question(host_, Type::kAny, dns::kInternet));
  write(writer, kSrv | kA | kAaaa, dns::Writer::Section::kAuthority, interface,
        ResponseKind::kLegacy);
}

RecordSet Records::known(const dns::Reader& message, const dns::Record& record,
                         std::uint32_t interface) const noexcept {
  if ((record.klass & ~dns::kTopBit) != dns::kInternet) {
    return 0;
  }
  RecordSet kind = 0;
  if (record.type == Type::kPtr) {
    const Result<dns::Name> target = message.name_at(record.data_offset);
    if (target && record.name == services_ && *target == type_) {
      kind = kServicesPtr;
    } else if (target && record.name == type_ && *target == instance_) {
      kind = kInstancePtr;
    }
  } else if (record.type == Type::kSrv && record.name == instance_) {
    kind = compare_srv(message, record) == Conflict::kNone ? kSrv : RecordSet{0};
  } else if (record.name == host_ && compare_address(record) == Conflict::kNone) {
    kind = record.type == Type::kA ? kA : kAaaa;
    kind = count(kind, interface) == 1 ? kind : RecordSet{0};
  }
  return record.ttl_s >= life_s(kind) / 2 ? kind : RecordSet{0};
}

Records::Conflict Records::compare_srv(const dns::Reader& message,
                                       const dns::Record& record) const noexcept {
  constexpr std::size_t kFixed = 6;  // priority and weight, ours 0; port
  const Result<dns::Name> target = message.name_at(record.data_offset + kFixed);
  if (record.data.size() <= kFixed || !target) {
    return Conflict::kNone;  // no sender of SRV records
  }
  const std::uint16_t port = service_.announce.port;
  const std::array<std::byte, kFixed> ours{std::byte{0},
                                           std::byte{0},
                                           std::byte{0},
                                           std::byte{0},
                                           static_cast<std::byte>(port >> 8),
                                           static_cast<std::byte>(port & 0xff)};
  const auto fixed = record.data.first(kFixed);
  if (std::ranges::equal(fixed, ours) && *target == host_) {
    return Conflict::kNone;
  }
  const bool below = std::ranges::equal(fixed, ours)
                         ? std::ranges::lexicographical_compare(target->bytes(), host_.bytes())
                         : std::ranges::lexicographical_compare(fixed, ours);
  return below ? Conflict::kBelow : Conflict::kAbove;
}

// An address that any of our interfaces has is ours: two of them may be on one link.
Records::Conflict Records::compare_address(const dns::Record& record) const noexcept {
  const RecordSet kind = record.type == Type::kA ? kA : kAaaa;
  std::optional<std::span<const std::byte>> least;
  for (const hal::InterfaceAddress& address : addresses_) {
    const auto bytes = record_data(address);
    if (std::ranges::equal(bytes, record.data)) {
      return Conflict::kNone;
    }
    if (record_kind(address) == kind &&
        (!least || std::ranges::lexicographical_compare(bytes, *least))) {
      least = bytes;
    }
  }
  const bool below = least && std::ranges::lexicographical_compare(record.data, *least);
  return below ? Conflict::kBelow : Conflict::kAbove;
}

Records::Conflict Records::conflict(const dns::Reader& message,
                                    const dns::Record& record) const noexcept {
  if ((record.klass & ~dns::kTopBit) != dns::kInternet || record.ttl_s == 0) {
    return Conflict::kNone;
  }
  if (record.type == Type::kSrv && record.name == instance_) {
    return compare_srv(message, record);
  }
  const bool address = (record.type == Type::kA && record.data.size() == 4) ||
                       (record.type == Type::kAaaa && record.data.size() == 16);
  return address && record.name == host_ ? compare_address(record) : Conflict::kNone;
}

}  // namespace stof::firmware

// What others say of our names.
#include <algorithm>
#include <optional>

#include "firmware/discovery/mdns_records.h"

namespace stof::firmware {

namespace dns = wire::dns;
using dns::Type;

std::span<const std::byte> record_data(const hal::InterfaceAddress& address) noexcept {
  const auto all = std::as_bytes(std::span(address.address));
  return hal::is_ipv4(address.address) ? all.last(4) : all;
}

RecordSet record_kind(const hal::InterfaceAddress& address) noexcept {
  return hal::is_ipv4(address.address) ? kA : kAaaa;
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
    kind = compare_srv(message, record) == Rival::kNone ? kSrv : RecordSet{0};
  } else if (record.name == host_ && compare_address(record) == Rival::kNone) {
    kind = record.type == Type::kA ? kA : kAaaa;
    kind = count(kind, interface) == 1 ? kind : RecordSet{0};
  }
  return record.ttl_s >= life_s(kind) / 2 ? kind : RecordSet{0};
}

Records::Rival Records::compare_srv(const dns::Reader& message,
                                    const dns::Record& record) const noexcept {
  constexpr std::size_t kFixed = 6;  // priority and weight, ours 0; port
  const Result<dns::Name> target = message.name_at(record.data_offset + kFixed);
  if (record.data.size() <= kFixed || !target) {
    return Rival::kNone;  // no sender of SRV records
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
    return Rival::kNone;
  }
  const bool below = std::ranges::equal(fixed, ours)
                         ? std::ranges::lexicographical_compare(target->bytes(), host_.bytes())
                         : std::ranges::lexicographical_compare(fixed, ours);
  return below ? Rival::kBelow : Rival::kAbove;
}

// An address that any of our interfaces has is ours: two of them may be on one link.
Records::Rival Records::compare_address(const dns::Record& record) const noexcept {
  const RecordSet kind = record.type == Type::kA ? kA : kAaaa;
  std::optional<std::span<const std::byte>> least;
  for (const hal::InterfaceAddress& address : addresses_) {
    const auto bytes = record_data(address);
    if (std::ranges::equal(bytes, record.data)) {
      return Rival::kNone;
    }
    if (record_kind(address) == kind &&
        (!least || std::ranges::lexicographical_compare(bytes, *least))) {
      least = bytes;
    }
  }
  const bool below = least && std::ranges::lexicographical_compare(record.data, *least);
  return below ? Rival::kBelow : Rival::kAbove;
}

Records::Rival Records::rival(const dns::Reader& message,
                              const dns::Record& record) const noexcept {
  if ((record.klass & ~dns::kTopBit) != dns::kInternet || record.ttl_s == 0) {
    return Rival::kNone;
  }
  if (record.type == Type::kSrv && record.name == instance_) {
    return compare_srv(message, record);
  }
  const bool address = (record.type == Type::kA && record.data.size() == 4) ||
                       (record.type == Type::kAaaa && record.data.size() == 16);
  return address && record.name == host_ ? compare_address(record) : Rival::kNone;
}

}  // namespace stof::firmware

#include "firmware/wire/dns.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::wire::dns {
namespace {

constexpr std::size_t kMostLabel = 63;
constexpr unsigned kPointer =
    0xc0;  // upper two bits of a length: the rest of the name is elsewhere
constexpr std::size_t kMostPlace = 0x3fff;  // that a pointer reaches

constexpr unsigned value_of(std::byte byte) noexcept { return std::to_integer<unsigned>(byte); }

constexpr std::uint16_t u16_at(std::span<const std::byte> bytes, std::size_t at) noexcept {
  return static_cast<std::uint16_t>((value_of(bytes[at]) << 8) | value_of(bytes[at + 1]));
}

constexpr std::byte lower(std::byte byte) noexcept {
  return byte >= std::byte{'A'} && byte <= std::byte{'Z'} ? byte | std::byte{0x20} : byte;
}

}  // namespace

Name::Name(std::initializer_list<std::string_view> labels) noexcept {
  for (const std::string_view label : labels) {
    static_cast<void>(append(label));
  }
}

Status Name::append(std::string_view label) noexcept {
  if (label.empty() || label.size() > kMostLabel || size_ + 1 + label.size() > kMost) {
    return Status::kTooLarge;
  }
  bytes_[size_ - 1] = static_cast<std::byte>(label.size());
  const auto bytes = std::as_bytes(std::span(label));
  std::ranges::copy(bytes, bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += 1 + label.size();
  bytes_[size_ - 1] = std::byte{0};
  return Status::kOk;
}

std::string_view Name::first_label() const noexcept {
  // Bytes and characters are the same memory.
  return {reinterpret_cast<const char*>(bytes_.data()) + 1, value_of(bytes_[0])};
}

Name Name::parent() const noexcept {
  Name rest;
  if (!is_root()) {
    const auto from = bytes().subspan(1 + value_of(bytes_[0]));
    std::ranges::copy(from, rest.bytes_.begin());
    rest.size_ = from.size();
  }
  return rest;
}

bool operator==(const Name& a, const Name& b) noexcept {
  // Lengths are below 64 and so no letters.
  return std::ranges::equal(a.bytes(), b.bytes(), {}, lower, lower);
}

std::optional<std::uint16_t> Reader::number() noexcept {
  if (message_.size() - at_ < 2) {
    return std::nullopt;
  }
  at_ += 2;
  return u16_at(message_, at_ - 2);
}

Result<Header> Reader::header() noexcept {
  if (message_.size() < kHeaderBytes) {
    return fail(Status::kCorrupt);
  }
  at_ = kHeaderBytes;
  return Header{.id = u16_at(message_, 0),
                .flags = u16_at(message_, 2),
                .questions = u16_at(message_, 4),
                .answers = u16_at(message_, 6),
                .authorities = u16_at(message_, 8),
                .additionals = u16_at(message_, 10)};
}

// Each pointer has to lead further back than the one before, so that every name ends.
Result<Name> Reader::name_at(std::size_t offset) const noexcept {
  Name name;
  std::size_t lowest = offset;
  for (std::size_t at = offset; at < message_.size();) {
    const unsigned length = value_of(message_[at]);
    if (length == 0) {
      return name;
    }
    if (length >= kPointer) {
      if (message_.size() - at < 2) {
        break;
      }
      const std::size_t pointer = u16_at(message_, at);
      const std::size_t target = pointer & kMostPlace;
      if (target >= lowest || target < kHeaderBytes) {
        break;
      }
      lowest = target;
      at = target;
      continue;
    }
    if (length > kMostLabel || message_.size() - at - 1 < length) {
      break;
    }
    const auto label = message_.subspan(at + 1, length);
    if (name.append({reinterpret_cast<const char*>(label.data()), label.size()}) != Status::kOk) {
      break;
    }
    at += 1 + length;
  }
  return fail(Status::kCorrupt);
}

Result<Name> Reader::name() noexcept {
  const Result<Name> name = name_at(at_);
  if (!name) {
    return name;
  }
  // Where it ends here: behind its 0 or its first pointer. name_at() has seen all of it.
  while (value_of(message_[at_]) != 0 && value_of(message_[at_]) < kPointer) {
    at_ += 1 + value_of(message_[at_]);
  }
  at_ += value_of(message_[at_]) == 0 ? 1U : 2U;
  return name;
}

Result<Question> Reader::question() noexcept {
  const Result<Name> name = this->name();
  const std::optional<std::uint16_t> type = name ? number() : std::nullopt;
  const std::optional<std::uint16_t> klass = type ? number() : std::nullopt;
  if (!klass) {
    return fail(Status::kCorrupt);
  }
  return Question{.name = *name, .type = static_cast<Type>(*type), .klass = *klass};
}

Result<Record> Reader::record() noexcept {
  const Result<Question> head = question();
  if (!head || message_.size() - at_ < 6) {
    return fail(Status::kCorrupt);
  }
  Record record{.name = head->name,
                .type = head->type,
                .klass = head->klass,
                .ttl_s = (std::uint32_t{u16_at(message_, at_)} << 16) | u16_at(message_, at_ + 2),
                .data_offset = at_ + 6,
                .data = {}};
  const std::size_t length = u16_at(message_, at_ + 4);
  at_ += 6;
  if (message_.size() - at_ < length) {
    return fail(Status::kCorrupt);
  }
  record.data = message_.subspan(at_, length);
  at_ += length;
  return record;
}

Writer::Writer(std::span<std::byte> space, std::uint16_t id, std::uint16_t flags) noexcept
    : space_(space) {
  STOF_CHECK(space.size() >= kHeaderBytes);
  std::ranges::fill(space.first(kHeaderBytes), std::byte{0});
  size_ = 0;
  put_u16(id);
  put_u16(flags);
  size_ = kHeaderBytes;
}

void Writer::put(std::byte value) noexcept {
  if (size_ < space_.size()) {
    space_[size_++] = value;
  } else {
    full_ = true;
  }
}

void Writer::put_u16(std::uint16_t value) noexcept {
  put(static_cast<std::byte>(value >> 8));
  put(static_cast<std::byte>(value & 0xff));
}

std::optional<std::size_t> Writer::place_of(const Name& name) const noexcept {
  const Reader written(space_.first(size_));
  for (const std::size_t place : std::span(places_).first(places_count_)) {
    if (const Result<Name> there = written.name_at(place); there && *there == name) {
      return place;
    }
  }
  return std::nullopt;
}

void Writer::put_name(const Name& name, bool compressed) noexcept {
  // Names are looked for among those that are whole: not in the one that is being written.
  std::size_t known = places_count_;
  for (Name rest = name; !rest.is_root(); rest = rest.parent()) {
    if (const auto place = compressed ? place_of(rest) : std::nullopt) {
      put_u16(static_cast<std::uint16_t>((kPointer << 8) | *place));
      places_count_ = known;
      return;
    }
    if (known < kPlaces && size_ <= kMostPlace) {
      places_[known++] = static_cast<std::uint16_t>(size_);
    }
    for (const std::byte byte : rest.bytes().first(1 + rest.first_label().size())) {
      put(byte);
    }
  }
  put(std::byte{0});
  places_count_ = known;
}

bool Writer::question(const Name& name, Type type, std::uint16_t klass) noexcept {
  put_name(name, true);
  put_u16(static_cast<std::uint16_t>(type));
  put_u16(klass);
  if (full_) {
    size_ = kept_;
    places_count_ = places_kept_;
    full_ = false;
    complete_ = false;
    return false;
  }
  ++counts_[0];
  kept_ = size_;
  places_kept_ = places_count_;
  return true;
}

void Writer::begin_record(const Name& name, Type type, std::uint16_t klass,
                          std::uint32_t ttl_s) noexcept {
  put_name(name, true);
  put_u16(static_cast<std::uint16_t>(type));
  put_u16(klass);
  put_u16(static_cast<std::uint16_t>(ttl_s >> 16));
  put_u16(static_cast<std::uint16_t>(ttl_s & 0xffff));
  length_at_ = size_;
  put_u16(0);
}

void Writer::data_u16(std::uint16_t value) noexcept { put_u16(value); }

void Writer::data(std::span<const std::byte> bytes) noexcept {
  for (const std::byte byte : bytes) {
    put(byte);
  }
}

void Writer::data_text(std::string_view key, std::string_view value) noexcept {
  STOF_CHECK(key.size() + 1 + value.size() <= 255);
  put(static_cast<std::byte>(key.size() + 1 + value.size()));
  data(std::as_bytes(std::span(key)));
  put(std::byte{'='});
  data(std::as_bytes(std::span(value)));
}

void Writer::data_name(const Name& name, bool compressed) noexcept { put_name(name, compressed); }

bool Writer::finish(Section section) noexcept {
  if (full_) {
    size_ = kept_;
    places_count_ = places_kept_;
    full_ = false;
    complete_ = false;
    return false;
  }
  const std::size_t length = size_ - length_at_ - 2;
  space_[length_at_] = static_cast<std::byte>(length >> 8);
  space_[length_at_ + 1] = static_cast<std::byte>(length & 0xff);
  ++counts_[static_cast<std::size_t>(section)];
  kept_ = size_;
  places_kept_ = places_count_;
  return true;
}

std::span<const std::byte> Writer::message() noexcept {
  for (std::size_t section = 0; section < counts_.size(); ++section) {
    space_[4 + 2 * section] = static_cast<std::byte>(counts_[section] >> 8);
    space_[5 + 2 * section] = static_cast<std::byte>(counts_[section] & 0xff);
  }
  return space_.first(kept_);
}

bool Writer::empty() const noexcept { return kept_ == kHeaderBytes; }

}  // namespace stof::wire::dns

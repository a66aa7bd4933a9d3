#include "firmware/records/record_disk.h"

#include <algorithm>
#include <string_view>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"

namespace stof::records {
namespace {

constexpr std::string_view kMagic{"STOFDOC\0", 8};
constexpr std::uint16_t kVersion = 1;
constexpr std::size_t kHeadUsed = 32;
constexpr std::uint32_t kAbsent = 1;
constexpr std::size_t kPart = 4096;  // copied at once

// Where each document begins in its area; the last one is the end.
constexpr std::array<std::size_t, kDocuments + 1> kPlaces = [] {
  constexpr std::size_t kSmall = std::size_t{64} << 10;
  constexpr std::size_t kLarge = std::size_t{1536} << 10;
  constexpr std::array<std::size_t, kDocuments> kSizes{kSmall, kSmall, kSmall, kSmall, kSmall,
                                                       kSmall, kSmall, kLarge, kLarge};
  std::array<std::size_t, kDocuments + 1> places{};
  for (std::size_t i = 0; i < kDocuments; ++i) {
    places[i + 1] = places[i] + kSizes[i];
  }
  return places;
}();
static_assert(kPlaces.back() <= kEraseBlockBytes);

constexpr std::size_t number(Document document) noexcept {
  return static_cast<std::size_t>(document);
}

using Head = std::array<std::byte, kHeadBytes>;

Status first_of(Status a, Status b) noexcept { return a == Status::kOk ? b : a; }

}  // namespace

std::size_t most_bytes(Document document) noexcept {
  return kPlaces[number(document) + 1] - kPlaces[number(document)] - kHeadBytes;
}

std::size_t RecordDisk::place_of(std::size_t area, Document document) const noexcept {
  return areas_[area] + kPlaces[number(document)];
}

RecordDisk::Record RecordDisk::look(std::size_t area, Document document) noexcept {
  Record record{.found = Found::kDamaged};
  Head head;
  if (disk_.read(place_of(area, document), head) != Status::kOk) {
    return record;
  }
  // Of a disk that is new or erased.
  const auto is_all = [&head](std::byte value) {
    return std::ranges::all_of(head, [value](std::byte byte) { return byte == value; });
  };
  if (is_all(std::byte{0}) || is_all(std::byte{0xFF})) {
    record.found = Found::kNothing;
    return record;
  }
  const std::span<const std::byte, kHeadUsed> used = std::span(head).first<kHeadUsed>();
  const bool ours = std::ranges::equal(used.first<8>(), std::as_bytes(std::span(kMagic))) &&
                    wire::get_u16(used.subspan<8, 2>()) == kVersion &&
                    wire::get_u16(used.subspan<10, 2>()) == number(document) &&
                    wire::crc32c(used.first<kHeadUsed - 4>()) == wire::get_u32(used.last<4>());
  record.generation = wire::get_u32(used.subspan<12, 4>());
  record.bytes = wire::get_u32(used.subspan<16, 4>());
  record.absent = (wire::get_u32(used.subspan<24, 4>()) & kAbsent) != 0;
  if (!ours || record.bytes > most_bytes(document)) {
    return {.found = Found::kDamaged};
  }
  std::uint32_t crc = 0;
  std::array<std::byte, kPart> part;
  for (std::size_t at = 0; at < record.bytes; at += kPart) {
    const std::span<std::byte> to = std::span(part).first(std::min(kPart, record.bytes - at));
    if (disk_.read(place_of(area, document) + kHeadBytes + at, to) != Status::kOk) {
      return {.found = Found::kDamaged};
    }
    crc = wire::crc32c(to, crc);
  }
  if (crc != wire::get_u32(used.subspan<20, 4>())) {
    return {.found = Found::kDamaged};
  }
  record.found = Found::kWhole;
  return record;
}

Status RecordDisk::write_head(std::size_t area, Document document, const Record& record,
                              std::uint32_t crc) noexcept {
  Head head{};
  const std::span<std::byte, kHeadUsed> used = std::span(head).first<kHeadUsed>();
  std::ranges::copy(std::as_bytes(std::span(kMagic)), used.begin());
  wire::put_u16(used.subspan<8, 2>(), kVersion);
  wire::put_u16(used.subspan<10, 2>(), static_cast<std::uint16_t>(number(document)));
  wire::put_u32(used.subspan<12, 4>(), record.generation);
  wire::put_u32(used.subspan<16, 4>(), record.bytes);
  wire::put_u32(used.subspan<20, 4>(), crc);
  wire::put_u32(used.subspan<24, 4>(), record.absent ? kAbsent : 0);
  wire::put_u32(used.last<4>(), wire::crc32c(used.first<kHeadUsed - 4>()));
  return first_of(disk_.write(place_of(area, document), head), disk_.flush());
}

// The order in which head and bytes come to the medium is of no account: the sum is that of both.
Status RecordDisk::write(std::size_t area, Document document, const Record& record,
                         std::span<const std::byte> bytes) noexcept {
  const Status written =
      bytes.empty() ? Status::kOk : disk_.write(place_of(area, document) + kHeadBytes, bytes);
  return written == Status::kOk ? write_head(area, document, record, wire::crc32c(bytes)) : written;
}

Status RecordDisk::copy(std::size_t from, std::size_t to, Document document, Document as,
                        std::uint32_t generation) noexcept {
  Record record = look(from, document);
  if (!record.whole()) {
    return Status::kDeviceError;
  }
  if (record.bytes > most_bytes(as)) {
    return Status::kTooLarge;
  }
  std::uint32_t crc = 0;
  std::array<std::byte, kPart> part;
  for (std::size_t at = 0; at < record.bytes; at += kPart) {
    const std::span<std::byte> bytes = std::span(part).first(std::min(kPart, record.bytes - at));
    const std::size_t behind = kHeadBytes + at;
    Status status = disk_.read(place_of(from, document) + behind, bytes);
    if (status == Status::kOk) {
      status = disk_.write(place_of(to, as) + behind, bytes);
    }
    if (status != Status::kOk) {
      return status;
    }
    crc = wire::crc32c(bytes, crc);
  }
  record.generation = generation;
  return write_head(to, as, record, crc);
}

Status RecordDisk::mend() noexcept {
  Status worst = Status::kOk;
  for (std::size_t i = 0; i < kDocuments; ++i) {
    const auto document = static_cast<Document>(i);
    const std::array<Record, kAreas> found = look(document);
    for (std::size_t area = 0; area < kAreas; ++area) {
      const Record& best = found[1 - area];
      if (best.newer_than(found[area])) {
        worst = first_of(worst, copy(1 - area, area, document, document, best.generation));
      }
    }
    const bool lost = !found[0].whole() && !found[1].whole() && found[0].found == Found::kDamaged &&
                      found[1].found == Found::kDamaged;
    worst = lost ? first_of(worst, Status::kDeviceError) : worst;
  }
  uneven_ = worst != Status::kOk;
  return worst;
}

Result<std::optional<std::size_t>> RecordDisk::load(Document document,
                                                    std::span<std::byte> space) noexcept {
  const std::array<Record, kAreas> found = look(document);
  const std::size_t area = found[1].newer_than(found[0]) ? 1 : 0;
  const Record& best = found[area];
  if (!best.whole()) {
    // One that is damaged beside one that was never written: the first save was cut.
    const bool lost = found[0].found == Found::kDamaged && found[1].found == Found::kDamaged;
    return lost ? Result<std::optional<std::size_t>>(fail(Status::kDeviceError)) : std::nullopt;
  }
  if (best.absent) {
    return std::nullopt;
  }
  if (best.bytes > space.size()) {
    return fail(Status::kTooLarge);
  }
  const Status read = disk_.read(place_of(area, document) + kHeadBytes, space.first(best.bytes));
  return read == Status::kOk ? Result<std::optional<std::size_t>>(std::size_t{best.bytes})
                             : fail(read);
}

Status RecordDisk::save(Document document, std::span<const std::byte> bytes) noexcept {
  return put(document, bytes, false);
}

// A document that cannot be read in either area is no reason to take no other one: what matters is
// that each document stands in the area that is not written.
Status RecordDisk::mend_before_writing() noexcept {
  if (!uneven_) {
    return Status::kOk;
  }
  static_cast<void>(mend());
  for (std::size_t i = 0; i < kDocuments; ++i) {
    const std::array<Record, kAreas> found = look(static_cast<Document>(i));
    if (found[0].newer_than(found[1]) || found[1].newer_than(found[0])) {
      return Status::kDeviceError;
    }
  }
  uneven_ = false;
  return Status::kOk;
}

Status RecordDisk::put(Document document, std::span<const std::byte> bytes, bool absent) noexcept {
  if (bytes.size() > most_bytes(document)) {
    return Status::kTooLarge;
  }
  if (const Status status = mend_before_writing(); status != Status::kOk) {
    return status;
  }
  const std::array<Record, kAreas> found = look(document);
  const Record next{.found = Found::kWhole,
                    .generation = std::max(found[0].generation, found[1].generation) + 1,
                    .bytes = static_cast<std::uint32_t>(bytes.size()),
                    .absent = absent};
  uneven_ = true;
  if (const Status status = write(0, document, next, bytes); status != Status::kOk) {
    return status;
  }
  // From here on it is saved: where the second area takes nothing, the next save says so.
  uneven_ = write(1, document, next, bytes) != Status::kOk;
  return Status::kOk;
}

Status RecordDisk::set_aside(Document document, std::optional<Document> aside) noexcept {
  if (const Status status = mend_before_writing(); status != Status::kOk) {
    return status;
  }
  const Record now = look(0, document);
  if (aside && now.whole() && !now.absent) {
    const std::array<Record, kAreas> there = look(*aside);
    const std::uint32_t next = std::max(there[0].generation, there[1].generation) + 1;
    uneven_ = true;
    for (std::size_t area = 0; area < kAreas; ++area) {
      if (const Status status = copy(area, area, document, *aside, next); status != Status::kOk) {
        return status;
      }
    }
    uneven_ = false;
  }
  return put(document, {}, true);
}

}  // namespace stof::records

#include "firmware/records/record_disk.h"

#include <algorithm>

#include "firmware/wire/crc32c.h"

namespace stof::records {
namespace {

constexpr std::size_t kPart = 4096;  // copied at once

Status first_of(Status a, Status b) noexcept { return a == Status::kOk ? b : a; }

}  // namespace

RecordDisk::RecordDisk(hal::Disk& disk) noexcept : disk_(disk), areas_(find_areas(disk)) {
  read_directories();
}

bool RecordDisk::cut_off() const noexcept {
  return std::ranges::any_of(areas_.at, [this](std::size_t area) {
    return area > disk_.bytes() || disk_.bytes() - area < kDirectoryPlace + kHeadBytes;
  });
}

void RecordDisk::read_directories() noexcept {
  bool damaged = true;
  for (std::size_t area = 0; area < kAreas; ++area) {
    Sector sector;
    const bool read = disk_.read(areas_.at[area] + kDirectoryPlace, sector) == Status::kOk;
    const auto directory = read ? read_directory(sector) : std::nullopt;
    if (directory && directory->area == area) {
      directories_[area] = directory;
      std::ranges::transform(newest_, directory->newest, newest_.begin(),
                             [](std::uint32_t a, std::uint32_t b) { return std::max(a, b); });
    }
    damaged = damaged && !(read && is_blank(sector));
  }
  if (directories_[0] || directories_[1]) {
    return;
  }
  // A power cut takes one of them at most, and records are listed only once there are both.
  for (std::size_t i = 0; i < kDocuments && !damaged; ++i) {
    const auto document = static_cast<Document>(i);
    damaged = look(0, document).listed || look(1, document).listed;
  }
  if (damaged) {  // nobody knows what there was: all of this that is not there is lost
    for (const Document document :
         {Document::kSettings, Document::kLimits, Document::kKeys, Document::kCalibration}) {
      newest_[number(document)] = 1;
    }
  }
}

// As it stands there, whatever the directories say.
RecordDisk::Record RecordDisk::look(std::size_t area, Document document) noexcept {
  constexpr Record kDamagedOne{.found = Found::kDamaged};
  Sector sector;
  if (disk_.read(place_of(area, document), sector) != Status::kOk) {
    return kDamagedOne;
  }
  if (is_blank(sector)) {
    return {};
  }
  const auto head = read_head(std::span(sector).first<kHeadUsed>());
  if (!head || head->document != document) {
    return kDamagedOne;
  }
  std::uint32_t crc = 0;
  std::array<std::byte, kPart> part;
  for (std::size_t at = 0; at < head->bytes; at += kPart) {
    const std::span<std::byte> to = std::span(part).first(std::min(kPart, head->bytes - at));
    if (disk_.read(place_of(area, document) + kHeadBytes + at, to) != Status::kOk) {
      return kDamagedOne;
    }
    crc = wire::crc32c(to, crc);
  }
  if (crc != head->crc) {
    return kDamagedOne;
  }
  return {.found = Found::kWhole,
          .generation = head->generation,
          .bytes = head->bytes,
          .absent = head->absent,
          .listed = head->listed};
}

// One that is older than the directories list is an older copy that somebody put back. The first
// area is written first: a save that was cut there leaves the second one older by one, with its own
// directory.
RecordDisk::Pair RecordDisk::look(Document document) noexcept {
  const std::size_t i = number(document);
  Pair found{look(0, document), look(1, document)};
  const std::optional<Directory>& second = directories_[1];
  const std::uint32_t one_less = newest_[i] - (newest_[i] > 0 ? 1 : 0);
  const std::array<std::uint32_t, kAreas> least{
      newest_[i], second ? std::max(second->newest[i], one_less) : newest_[i]};
  for (std::size_t area = 0; area < kAreas; ++area) {
    if (found[area].whole() && found[area].generation < least[area]) {
      found[area].found = Found::kDamaged;
    }
  }
  return found;
}

RecordDisk::All RecordDisk::look_at_all() noexcept {
  All all;
  for (std::size_t i = 0; i < kDocuments; ++i) {
    all[i] = look(static_cast<Document>(i));
  }
  return all;
}

// One that is damaged beside one that was never written: the first save was cut.
bool RecordDisk::is_lost(Document document, const Pair& found) const noexcept {
  return !found[0].whole() && !found[1].whole() &&
         (newest_[number(document)] > 0 ||
          (found[0].found == Found::kDamaged && found[1].found == Found::kDamaged));
}

Status RecordDisk::write_head(std::size_t area, Document document, const Record& record,
                              std::uint32_t crc) noexcept {
  const Sector sector = records::write_head({.document = document,
                                             .generation = record.generation,
                                             .bytes = record.bytes,
                                             .crc = crc,
                                             .absent = record.absent,
                                             .listed = true});
  return first_of(disk_.write(place_of(area, document), sector), disk_.flush());
}

Status RecordDisk::write_directory(std::size_t area) noexcept {
  const std::optional<Directory>& now = directories_[area];
  const std::optional<Directory>& other = directories_[1 - area];
  // Both have one generation where they say the same.
  const std::uint32_t generation =
      other && other->newest == newest_
          ? other->generation
          : std::max(now ? now->generation : 0, other ? other->generation : 0) + 1;
  const Directory next{
      .area = static_cast<std::uint16_t>(area), .generation = generation, .newest = newest_};
  const Status status =
      first_of(disk_.write(areas_.at[area] + kDirectoryPlace, records::write_directory(next)),
               disk_.flush());
  if (status == Status::kOk) {
    directories_[area] = next;
  } else {
    directories_[area].reset();  // what is there now is not known
  }
  return status;
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

bool RecordDisk::is_even(const All& found) const noexcept {
  return std::ranges::all_of(directories_,
                             [this](const std::optional<Directory>& directory) {
                               return directory && directory->newest == newest_;
                             }) &&
         std::ranges::none_of(found, [](const Pair& pair) {
           return pair[0].newer_than(pair[1]) || pair[1].newer_than(pair[0]);
         });
}

// The directory first: until it is there, no record is listed.
Status RecordDisk::mend(std::size_t area, All& found) noexcept {
  if (!directories_[area] || directories_[area]->newest != newest_) {
    if (const Status status = write_directory(area); status != Status::kOk) {
      return status;
    }
  }
  Status worst = Status::kOk;
  for (std::size_t i = 0; i < kDocuments; ++i) {
    const Record best = found[i][1 - area];
    if (best.newer_than(found[i][area])) {
      const auto document = static_cast<Document>(i);
      const Status status = copy(1 - area, area, document, document, best.generation);
      found[i][area] = status == Status::kOk ? best : Record{.found = Found::kDamaged};
      worst = first_of(worst, status);
    }
  }
  return worst;
}

Status RecordDisk::mend() noexcept {
  All found = look_at_all();
  for (std::size_t i = 0; i < kDocuments; ++i) {
    for (const Record& record : found[i]) {
      newest_[i] = std::max(newest_[i], record.whole() ? record.generation : 0);
    }
  }
  Status worst = Status::kOk;
  for (std::size_t area = 0; area < kAreas; ++area) {
    worst = first_of(worst, mend(area, found));
  }
  uneven_ = !is_even(found);
  for (std::size_t i = 0; i < kDocuments; ++i) {
    const bool lost = is_lost(static_cast<Document>(i), found[i]);
    worst = lost ? first_of(worst, Status::kDeviceError) : worst;
  }
  return worst == Status::kOk ? worst : Status::kDeviceError;
}

Result<std::optional<std::size_t>> RecordDisk::load(Document document,
                                                    std::span<std::byte> space) noexcept {
  const Pair found = look(document);
  const std::size_t area = found[1].newer_than(found[0]) ? 1 : 0;
  const Record& best = found[area];
  if (!best.whole()) {
    return is_lost(document, found) ? Result<std::optional<std::size_t>>(fail(Status::kDeviceError))
                                    : std::nullopt;
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

// A document that is lost is no reason to take no other one: what matters is that each document
// stands in the area that is not written.
Status RecordDisk::mend_before_writing() noexcept {
  if (uneven_) {
    static_cast<void>(mend());
  }
  return uneven_ ? Status::kDeviceError : Status::kOk;
}

Status RecordDisk::put(Document document, std::span<const std::byte> bytes, bool absent) noexcept {
  if (bytes.size() > most_bytes(document)) {
    return Status::kTooLarge;
  }
  if (const Status status = mend_before_writing(); status != Status::kOk) {
    return status;
  }
  std::uint32_t& newest = newest_[number(document)];
  const Record next{.found = Found::kWhole,
                    .generation = newest + 1,
                    .bytes = static_cast<std::uint32_t>(bytes.size()),
                    .absent = absent};
  uneven_ = true;
  if (const Status status = write(0, document, next, bytes); status != Status::kOk) {
    return status;
  }
  // From here on it is saved: where the medium takes no more, the next save says so.
  newest = next.generation;
  uneven_ = write_directory(0) != Status::kOk || write(1, document, next, bytes) != Status::kOk ||
            write_directory(1) != Status::kOk;
  return Status::kOk;
}

Status RecordDisk::set_aside(Document document, std::optional<Document> aside) noexcept {
  if (const Status status = mend_before_writing(); status != Status::kOk) {
    return status;
  }
  const Record now = look(document)[0];
  if (aside && now.whole() && !now.absent) {
    const std::uint32_t next = newest_[number(*aside)] + 1;
    uneven_ = true;
    for (std::size_t area = 0; area < kAreas; ++area) {
      if (const Status status = copy(area, area, document, *aside, next); status != Status::kOk) {
        return status;
      }
      newest_[number(*aside)] = next;
      if (const Status status = write_directory(area); status != Status::kOk) {
        return status;
      }
    }
    uneven_ = false;
  }
  return put(document, {}, true);
}

}  // namespace stof::records

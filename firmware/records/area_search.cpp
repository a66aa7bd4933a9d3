#include "firmware/records/area_search.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>

namespace stof::records {
namespace {

constexpr std::size_t kSearchedAtOnce = 16384;  // searched at once
constexpr std::string_view kBegin{"STOFD"};     // of both magics
// Parts overlap by as much: nothing that begins in one is missed.
constexpr std::size_t kOverlap = kBegin.size() - 1;

std::size_t area_before(std::size_t place, std::size_t in_area) noexcept {
  return place >= in_area && place < kNowhere ? place - in_area : kNowhere;
}

// What of an area is known gives the other one.
void derive(std::array<std::size_t, kAreas>& at) noexcept {
  if (at[0] == kNowhere) {
    at[0] = area_before(at[1], kBetweenAreas);
  } else if (at[1] == kNowhere) {
    at[1] = at[0] + kBetweenAreas;
  }
}

std::optional<Directory> directory_at(hal::Disk& disk, std::size_t place) noexcept {
  Sector sector;
  return disk.read(place, sector) == Status::kOk ? read_directory(sector) : std::nullopt;
}

std::optional<RecordHead> record_at(hal::Disk& disk, std::size_t place) noexcept {
  std::array<std::byte, kHeadUsed> bytes;
  return disk.read(place, bytes) == Status::kOk ? read_head(bytes) : std::nullopt;
}

// What lies anywhere.
struct Anywhere {
  std::array<std::size_t, kAreas> directories{kNowhere, kNowhere};  // their areas
  std::array<std::uint32_t, kAreas> newest{};
  std::size_t first_record = kNowhere;  // as of the first area
};

void look_at(hal::Disk& disk, std::size_t place, Anywhere& seen) noexcept {
  if (const auto directory = directory_at(disk, place)) {
    const std::size_t area = directory->area;
    const std::size_t begin = area_before(place, kDirectoryPlace);
    if (begin != kNowhere &&
        (seen.directories[area] == kNowhere || directory->generation > seen.newest[area])) {
      seen.directories[area] = begin;
      seen.newest[area] = directory->generation;
    }
  } else if (const auto head = record_at(disk, place); head && seen.first_record == kNowhere) {
    seen.first_record = area_before(place, kPlaces[number(head->document)]);
  }
}

Anywhere search(hal::Disk& disk) noexcept {
  Anywhere seen;
  std::array<std::byte, kSearchedAtOnce> part;
  const std::size_t end = std::min(disk.bytes(), kMostSearched);
  for (std::size_t at = 0; at < end; at += kSearchedAtOnce - kOverlap) {
    const std::span<std::byte> bytes = std::span(part).first(std::min(kSearchedAtOnce, end - at));
    if (disk.read(at, bytes) != Status::kOk) {
      continue;
    }
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (std::size_t here = text.find(kBegin); here != std::string_view::npos;
         here = text.find(kBegin, here + 1)) {
      look_at(disk, at + here, seen);
    }
  }
  return seen;
}

bool has_records(hal::Disk& disk, const std::array<std::size_t, kAreas>& at) noexcept {
  for (const std::size_t area : at) {
    for (std::size_t i = 0; i < kDocuments; ++i) {
      const auto head = record_at(disk, area + kPlaces[i]);
      if (head && number(head->document) == i) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

Areas find_areas(hal::Disk& disk) noexcept {
  Areas usual;
  if (disk.bytes() >= kRecordsBytes) {
    usual.at = {disk.bytes() - kRecordsBytes, disk.bytes() - kEraseBlockBytes};
  }
  for (std::size_t area = 0; area < kAreas; ++area) {
    const auto directory = directory_at(disk, usual.at[area] + kDirectoryPlace);
    usual.found = usual.found || (directory && directory->area == area);
  }
  if (usual.found) {
    return usual;
  }
  const Anywhere seen = search(disk);
  Areas elsewhere{.at = seen.directories, .found = true};
  if (seen.directories == std::array{kNowhere, kNowhere}) {
    usual.found = has_records(disk, usual.at);
    if (usual.found || seen.first_record == kNowhere) {
      return usual;
    }
    elsewhere.at[0] = seen.first_record;
  }
  derive(elsewhere.at);
  elsewhere.moved = elsewhere.at != usual.at;
  return elsewhere;
}

}  // namespace stof::records

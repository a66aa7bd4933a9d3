#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

// Where documents lie in an area, and the heads of their records. The bytes: README.md.
namespace stof::records {

// Which document. Each has a place of its own in both areas; the numbers are on the medium.
enum class Document : std::uint8_t {
  kSettings,
  kGoodSettings,
  kTrial,
  kLimits,
  kDamagedSettings,
  kKeys,
  kDamagedKeys,
  kCalibration,
  kDamagedCalibration,
};
inline constexpr std::size_t kDocuments = 9;

inline constexpr std::size_t kHeadBytes = 512;
inline constexpr std::size_t kHeadUsed = 32;
// An erase block of a card, at most: what a write that power cuts may take with it.
inline constexpr std::size_t kEraseBlockBytes = std::size_t{4} << 20;
// At the end of the disk: the first area, as much that is left alone, the second area.
inline constexpr std::size_t kRecordsBytes = 3 * kEraseBlockBytes;
inline constexpr std::size_t kAreas = 2;
inline constexpr std::size_t kBetweenAreas =
    2 * kEraseBlockBytes;  // from one's begin to the other's

// Where each document begins in its area; the last one is the end.
inline constexpr std::array<std::size_t, kDocuments + 1> kPlaces = [] {
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
// The directory of the area: its last 4 KiB.
inline constexpr std::size_t kDirectoryPlace = kEraseBlockBytes - 4096;
static_assert(kPlaces.back() <= kDirectoryPlace);

constexpr std::size_t number(Document document) noexcept {
  return static_cast<std::size_t>(document);
}
// Most bytes of a document.
constexpr std::size_t most_bytes(Document document) noexcept {
  return kPlaces[number(document) + 1] - kPlaces[number(document)] - kHeadBytes;
}

using Sector = std::array<std::byte, kHeadBytes>;

struct RecordHead {
  Document document{};
  std::uint32_t generation = 0;
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;  // of the bytes
  bool absent = false;    // there is none
  bool listed = false;    // there were directories when it was written
};

Sector write_head(const RecordHead& head) noexcept;
// Any bytes. None: no head, or damaged.
std::optional<RecordHead> read_head(std::span<const std::byte, kHeadUsed> bytes) noexcept;

// What an area says of both: which documents were ever written.
struct Directory {
  std::uint16_t area = 0;
  std::uint32_t generation = 0;                    // one more with each that is written
  std::array<std::uint32_t, kDocuments> newest{};  // of each document's records; 0: there was none
};

Sector write_directory(const Directory& directory) noexcept;
// Any bytes. None: no directory, or damaged.
std::optional<Directory> read_directory(const Sector& sector) noexcept;

// Of a disk that is new or erased.
bool is_blank(const Sector& bytes) noexcept;

}  // namespace stof::records

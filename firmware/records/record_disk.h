#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/disk.h"
#include "hal/store.h"

// Documents that outlive a power cut, on a partition without a file system. The bytes: README.md.
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
// An erase block of a card, at most: what a write that power cuts may take with it.
inline constexpr std::size_t kEraseBlockBytes = std::size_t{4} << 20;
// At the end of the disk: the first area, as much that is left alone, the second area.
inline constexpr std::size_t kRecordsBytes = 3 * kEraseBlockBytes;

// Most bytes of a document.
std::size_t most_bytes(Document document) noexcept;

// Two areas, each with a record of every document. At most one of them is written at a time, and
// only while the other one is whole: whatever a power cut does to the one that was written, all of
// its erase block, the other one has the old or the new document, and the others as they are. What
// was lost is written anew by mend(). For one thread; no heap.
class RecordDisk {
 public:
  // The disk outlives it and has kRecordsBytes at least, and whole erase blocks.
  explicit RecordDisk(hal::Disk& disk) noexcept
      : disk_(disk), areas_{disk.bytes() - kRecordsBytes, disk.bytes() - kEraseBlockBytes} {}

  // Both areas get what the other one has newer, or alone; at the start. kDeviceError: the medium
  // takes no writes, or cannot be read in both areas; what can be read stays.
  Status mend() noexcept;

  // As hal::Store.
  Result<std::optional<std::size_t>> load(Document document, std::span<std::byte> space) noexcept;
  // kTooLarge: it has no room for so many bytes.
  Status save(Document document, std::span<const std::byte> bytes) noexcept;
  // Where `aside` has room it gets the bytes.
  Status set_aside(Document document, std::optional<Document> aside) noexcept;

 private:
  static constexpr std::size_t kAreas = 2;
  enum class Found : std::uint8_t { kNothing, kDamaged, kWhole };
  // One record as it stands in one area.
  struct Record {
    Found found = Found::kNothing;
    std::uint32_t generation = 0;
    std::uint32_t bytes = 0;
    bool absent = false;  // it says that there is none

    bool whole() const noexcept { return found == Found::kWhole; }
    bool newer_than(const Record& other) const noexcept {
      return whole() && (!other.whole() || generation > other.generation);
    }
  };

  std::size_t place_of(std::size_t area, Document document) const noexcept;
  Record look(std::size_t area, Document document) noexcept;
  std::array<Record, kAreas> look(Document document) noexcept {
    return {look(0, document), look(1, document)};
  }
  Status write(std::size_t area, Document document, const Record& record,
               std::span<const std::byte> bytes) noexcept;
  Status write_head(std::size_t area, Document document, const Record& record,
                    std::uint32_t crc) noexcept;
  // Of the record of that area to the other area, or to another document of it.
  Status copy(std::size_t from, std::size_t to, Document document, Document as,
              std::uint32_t generation) noexcept;
  Status put(Document document, std::span<const std::byte> bytes, bool absent) noexcept;
  Status mend_before_writing() noexcept;

  hal::Disk& disk_;
  std::array<std::size_t, kAreas> areas_;
  bool uneven_ = true;  // the areas may differ: mend() before anything is written
};

// One document of them. For one thread.
class RecordStore final : public hal::Store {
 public:
  // disk outlives it.
  RecordStore(RecordDisk& disk, Document document, std::optional<Document> aside = {}) noexcept
      : disk_(disk), document_(document), aside_(aside) {}

  Result<std::optional<std::size_t>> load(std::span<std::byte> space) noexcept override {
    return disk_.load(document_, space);
  }
  Status save(std::span<const std::byte> bytes) noexcept override {
    return disk_.save(document_, bytes);
  }
  Status set_aside() noexcept override { return disk_.set_aside(document_, aside_); }

 private:
  RecordDisk& disk_;
  Document document_;
  std::optional<Document> aside_;
};

}  // namespace stof::records

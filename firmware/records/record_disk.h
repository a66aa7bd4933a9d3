#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/records/area_search.h"
#include "firmware/records/layout.h"
#include "hal/disk.h"
#include "hal/store.h"

// Documents that outlive a power cut, on a partition without a file system. The bytes: README.md.
namespace stof::records {

// Two areas, each with a record of every document and a directory of both. At most one of them is
// written at a time, and only while the other one is whole: whatever a power cut does to the one
// that was written, all of its erase block, the other one has the old or the new document, and the
// others as they are. What was lost is written anew by mend(). What a directory lists and no area
// has is lost, and not missing. For one thread; no heap.
class RecordDisk {
 public:
  // The disk outlives it. Reads where the areas are.
  explicit RecordDisk(hal::Disk& disk) noexcept;

  // Something is kept there.
  bool found() const noexcept { return areas_.found; }
  // The disk has become larger: the areas stay where they are.
  bool moved() const noexcept { return areas_.moved; }
  // Not all of both areas lies within the disk, it has become smaller: nothing can be saved.
  bool cut_off() const noexcept;

  // Both areas get what the other one has newer, or alone, and a directory; at the start.
  // kDeviceError: the medium takes no writes, or a document is lost; what can be read stays.
  Status mend() noexcept;

  // As hal::Store. kDeviceError also: it was there, and is in neither area, or only older.
  Result<std::optional<std::size_t>> load(Document document, std::span<std::byte> space) noexcept;
  // kTooLarge: it has no room for so many bytes.
  Status save(Document document, std::span<const std::byte> bytes) noexcept;
  // Where `aside` has room it gets the bytes.
  Status set_aside(Document document, std::optional<Document> aside) noexcept;

 private:
  enum class Found : std::uint8_t { kNothing, kDamaged, kWhole };
  // One record as it stands in one area.
  struct Record {
    Found found = Found::kNothing;
    std::uint32_t generation = 0;
    std::uint32_t bytes = 0;
    bool absent = false;  // it says that there is none
    bool listed = false;

    bool whole() const noexcept { return found == Found::kWhole; }
    bool newer_than(const Record& other) const noexcept {
      return whole() && (!other.whole() || generation > other.generation);
    }
  };
  using Pair = std::array<Record, kAreas>;
  using All = std::array<Pair, kDocuments>;

  void read_directories() noexcept;
  std::size_t place_of(std::size_t area, Document document) const noexcept {
    return areas_.at[area] + kPlaces[number(document)];
  }
  Record look(std::size_t area, Document document) noexcept;
  Pair look(Document document) noexcept;
  All look_at_all() noexcept;
  bool is_lost(Document document, const Pair& found) const noexcept;
  bool is_even(const All& found) const noexcept;
  Status mend(std::size_t area, All& found) noexcept;
  Status write(std::size_t area, Document document, const Record& record,
               std::span<const std::byte> bytes) noexcept;
  Status write_head(std::size_t area, Document document, const Record& record,
                    std::uint32_t crc) noexcept;
  Status write_directory(std::size_t area) noexcept;
  // Of the record of that area to the other area, or to another document of it.
  Status copy(std::size_t from, std::size_t to, Document document, Document as,
              std::uint32_t generation) noexcept;
  Status put(Document document, std::span<const std::byte> bytes, bool absent) noexcept;
  Status mend_before_writing() noexcept;

  hal::Disk& disk_;
  Areas areas_;
  std::array<std::optional<Directory>, kAreas> directories_{};
  std::array<std::uint32_t, kDocuments> newest_{};  // of what the directories shall list
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

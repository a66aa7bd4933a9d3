#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "firmware/records/layout.h"
#include "hal/disk.h"

// Where the areas of a disk lie, also when somebody has changed its size.
namespace stof::records {

// Whatever is read or written there is not within the disk.
inline constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max() / 2;
// From the disk's begin on; what lies behind that is not searched.
inline constexpr std::size_t kMostSearched = std::size_t{256} << 20;

struct Areas {
  std::array<std::size_t, kAreas> at{kNowhere, kNowhere};
  bool found = false;  // there is a directory or a record
  bool moved = false;  // they are not those of the disk's end
};

// The areas of the disk's end where one has a directory that says so. Else those of the newest
// directories anywhere; else, without any directory, of records at the disk's end; else those of
// the first record anywhere; else the disk's end. Reads all of the disk only where the disk's end
// has no directory. For one thread; no heap.
Areas find_areas(hal::Disk& disk) noexcept;

}  // namespace stof::records

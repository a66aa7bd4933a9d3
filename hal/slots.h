#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"

namespace stof::hal {

// Parts of a board's disk that updates know (board/image/README.md).
enum class DiskPart : std::uint8_t { kBoot, kSlotA, kSlotB };
inline constexpr std::size_t kDiskParts = 3;

// Two slots, each with a whole system, and the partition before them that says which one a start
// takes. For one thread; allocates nothing. One write at a time, which goes on while the caller
// does other things.
class Slots {
 public:
  virtual ~Slots() = default;

  // Bytes of a part, a multiple of 512.
  virtual std::size_t bytes(DiskPart part) const noexcept = 0;
  // As many as `to` has, from `offset` on, as they stand on the medium; blocks as long as the
  // medium takes. Not while a write is under way. kInvalidArgument: not within the part;
  // kDeviceError.
  virtual Status read(DiskPart part, std::size_t offset, std::span<std::byte> to) noexcept = 0;
  // Begins to write and to flush; the bytes stay as they are until progress() says other than
  // kTimeout. Not while another write is under way.
  virtual void write(DiskPart part, std::size_t offset,
                     std::span<const std::byte> bytes) noexcept = 0;
  // Of the last write. kOk: it is on the medium, or there was none. kTimeout: it is under way, ask
  // again. kDeviceError, kInvalidArgument: it failed; some of its bytes may be there.
  virtual Status progress() noexcept = 0;
};

}  // namespace stof::hal

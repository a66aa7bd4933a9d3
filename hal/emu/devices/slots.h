#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "hal/slots.h"

namespace stof::hal::emu {

// Slots in memory, with a log of what was written; slow, or broken, when told to be.
class Slots final : public hal::Slots {
 public:
  struct Write {
    DiskPart part;
    std::size_t offset;
    std::vector<std::byte> bytes;
    bool flushed = false;  // progress() has told it: a cut later than that cannot undo it
  };
  using Disk = std::array<std::vector<std::byte>, kDiskParts>;

  explicit Slots(Disk disk) : disk_(std::move(disk)) {}

  std::size_t bytes(DiskPart part) const noexcept override { return of(part).size(); }
  Status read(DiskPart part, std::size_t offset, std::span<std::byte> to) noexcept override;
  void write(DiskPart part, std::size_t offset, std::span<const std::byte> bytes) noexcept override;
  Status progress() noexcept override;

  const Disk& disk() const noexcept { return disk_; }
  Disk& disk() noexcept { return disk_; }
  const std::vector<Write>& log() const noexcept { return log_; }

  // Each write is under way for so many calls of progress().
  int delay = 0;
  // The medium takes no more after so many writes; below 0: it takes all.
  int breaks_after = -1;
  // A worn medium: what it takes into this byte of slot B, it gives back with a bit turned over.
  std::optional<std::size_t> worn_byte{};

 private:
  const std::vector<std::byte>& of(DiskPart part) const noexcept {
    return disk_[static_cast<std::size_t>(part)];
  }

  Disk disk_;
  std::vector<Write> log_;
  std::span<const std::byte> given_{};  // of the write that is under way
  int left_ = 0;
  Status last_ = Status::kOk;
};

}  // namespace stof::hal::emu

#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "hal/disk.h"

namespace stof::hal::emu {

// A disk in memory, with a log of what was written and flushed; broken when told to be.
class Disk final : public hal::Disk {
 public:
  // No bytes: a flush.
  struct Call {
    std::size_t offset;
    std::vector<std::byte> bytes;
  };

  explicit Disk(std::vector<std::byte> content) : content_(std::move(content)) {}

  std::size_t bytes() const noexcept override { return content_.size(); }
  Status read(std::size_t offset, std::span<std::byte> to) noexcept override;
  Status write(std::size_t offset, std::span<const std::byte> bytes) noexcept override;
  Status flush() noexcept override;

  std::vector<std::byte>& content() noexcept { return content_; }
  std::vector<Call>& log() noexcept { return log_; }

  // The medium takes no more after so many writes; below 0: it takes all.
  int breaks_after = -1;
  // What lies from here to there cannot be read.
  std::size_t unreadable_begin = 0;
  std::size_t unreadable_end = 0;

 private:
  bool holds(std::size_t offset, std::size_t count) const noexcept {
    return offset <= content_.size() && count <= content_.size() - offset;
  }

  std::vector<std::byte> content_;
  std::vector<Call> log_;
};

}  // namespace stof::hal::emu

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "firmware/update/boot_choice.h"
#include "firmware/update/release.h"
#include "hal/slots.h"

namespace stof::update {

// Writes a slot in its order, chunk by chunk: one is collected while the one before is written.
// Each is read back from the medium.
// All memory is taken at construction. For one thread.
class SlotWriter {
 public:
  // slots outlives it.
  explicit SlotWriter(hal::Slots& slots) : slots_(slots), memory_(kBuffers * kChunkBytes) {}

  // What was begun before is over, and what had not been written of it is left out. Not while
  // pump() says kTimeout. The slot's record is wiped first: from then on it is none to be started.
  void begin(Slot slot) noexcept;
  // Whether so many chunks more may be collected: else the medium is slower than whoever sends.
  bool has_room_for(std::size_t chunks) const noexcept {
    return collected_ + chunks <= written_ + kBuffers;
  }
  // For the next chunk; only while has_room_for(1).
  std::span<std::byte> room() noexcept { return buffer(collected_).first(kChunkBytes); }
  // The first so many bytes of room() are the next chunk.
  void put(std::size_t bytes) noexcept;
  // Begins what can be begun. kOk: all that was put is on the medium. kTimeout: not yet.
  // kDeviceError: the medium does not take it, or gives other bytes back; until begin().
  Status pump() noexcept;

 private:
  Status compare() noexcept;
  static constexpr std::size_t kBuffers = 2;
  std::span<std::byte> buffer(std::size_t chunk) noexcept {
    return std::span(memory_).subspan(chunk % kBuffers * kChunkBytes);
  }

  hal::Slots& slots_;
  std::vector<std::byte> memory_;
  std::array<std::byte, kWrittenBytes> nothing_{};
  std::array<std::size_t, kBuffers> sizes_{};
  Slot slot_ = Slot::kA;
  std::size_t collected_ = 0;  // chunks
  std::size_t written_ = 0;
  bool wiped_ = true;
  bool under_way_ = false;  // the wiping, or chunk `written_`
  Status failed_ = Status::kOk;
};

}  // namespace stof::update

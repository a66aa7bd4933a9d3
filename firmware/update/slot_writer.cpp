#include "firmware/update/slot_writer.h"

#include <algorithm>

namespace stof::update {

void SlotWriter::begin(Slot slot) noexcept {
  slot_ = slot;
  collected_ = 0;
  written_ = 0;
  wiped_ = false;
  under_way_ = false;
  failed_ = Status::kOk;
}

void SlotWriter::put(std::size_t bytes) noexcept {
  sizes_[collected_ % kBuffers] = bytes;
  ++collected_;
}

// What was written last with what the medium gives.
Status SlotWriter::compare() noexcept {
  constexpr std::size_t kPart = 4096;
  const std::span<const std::byte> chunk = buffer(written_).first(sizes_[written_ % kBuffers]);
  std::array<std::byte, kPart> part;
  for (std::size_t at = 0; at < chunk.size(); at += kPart) {
    const std::span<std::byte> back = std::span(part).first(std::min(kPart, chunk.size() - at));
    const Status read = slots_.read(part_of(slot_), written_ * kChunkBytes + at, back);
    if (read != Status::kOk || !std::ranges::equal(back, chunk.subspan(at, back.size()))) {
      return Status::kDeviceError;
    }
  }
  return Status::kOk;
}

Status SlotWriter::pump() noexcept {
  if (under_way_) {
    const Status status = slots_.progress();
    if (status == Status::kTimeout) {
      return status;
    }
    under_way_ = false;
    failed_ = status == Status::kOk && wiped_ ? compare() : status;
    written_ += wiped_ ? 1U : 0U;
    wiped_ = true;
  }
  if (failed_ != Status::kOk) {
    return failed_;
  }
  const hal::DiskPart part = part_of(slot_);
  if (!wiped_) {
    slots_.write(part, slots_.bytes(part) - kRecordBytes, nothing_);
  } else if (written_ < collected_) {
    slots_.write(part, written_ * kChunkBytes, buffer(written_).first(sizes_[written_ % kBuffers]));
  } else {
    return Status::kOk;
  }
  under_way_ = true;
  return Status::kTimeout;
}

}  // namespace stof::update

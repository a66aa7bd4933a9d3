#include "hal/emu/link.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::hal::emu {

Link::Link(int capacity, const FaultPlan& faults) : faults_(faults) {
  STOF_CHECK(capacity > 0);
  queue_.resize(static_cast<std::size_t>(capacity));
}

Status Link::send(std::span<const std::byte> datagram) noexcept {
  const Fault fault = faults_.at(calls_++);
  if (datagram.size() > kMaxDatagram) {
    return Status::kTooLarge;
  }
  if (fault.kind == FaultKind::kVanish) {
    return Status::kDeviceError;
  }
  if (fault.kind == FaultKind::kDrop) {
    return Status::kOk;
  }
  std::ranges::copy(datagram, scratch_.bytes.begin());
  scratch_.size = datagram.size();
  if (fault.kind == FaultKind::kDelay && !holding_) {
    held_ = scratch_;
    holding_ = true;
    return Status::kOk;
  }
  if (fault.kind == FaultKind::kTear) {
    scratch_.size /= 2;
  }
  if ((fault.kind == FaultKind::kTear || fault.kind == FaultKind::kCorrupt) && scratch_.size > 0) {
    scratch_.bytes[scratch_.size / 2] ^= std::byte{0xFF};
  }
  if (!push(scratch_)) {
    return Status::kWouldBlock;
  }
  // From here on the sender's datagram is on its way; what does not fit any more gets lost.
  if (fault.kind == FaultKind::kRepeat) {
    push(scratch_);
  }
  if (holding_) {
    holding_ = false;
    push(held_);
  }
  return Status::kOk;
}

std::optional<std::span<const std::byte>> Link::receive() noexcept {
  if (waiting_ == 0) {
    return std::nullopt;
  }
  scratch_ = queue_[static_cast<std::size_t>(first_)];
  first_ = (first_ + 1) % static_cast<int>(queue_.size());
  --waiting_;
  return std::span<const std::byte>(scratch_.bytes).first(scratch_.size);
}

bool Link::push(const Datagram& datagram) noexcept {
  const int capacity = static_cast<int>(queue_.size());
  if (waiting_ == capacity) {
    return false;
  }
  queue_[static_cast<std::size_t>((first_ + waiting_) % capacity)] = datagram;
  ++waiting_;
  return true;
}

}  // namespace stof::hal::emu

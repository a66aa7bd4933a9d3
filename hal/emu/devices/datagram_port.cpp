#include "hal/emu/devices/datagram_port.h"

#include <algorithm>
#include <utility>

#include "dsp/base/check.h"

namespace stof::hal::emu {

std::span<const std::byte> DatagramPort::Datagram::held() const noexcept {
  return std::span(bytes).first(std::min(size, bytes.size()));
}

DatagramPort::DatagramPort(int capacity, const FaultPlan& faults, std::uint16_t port)
    : port_(port), faults_(faults) {
  STOF_CHECK(capacity > 0);
  out_.ring.resize(static_cast<std::size_t>(capacity));
  in_.ring.resize(static_cast<std::size_t>(capacity));
}

Status DatagramPort::send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
                          std::size_t& sent) noexcept {
  sent = 0;
  for (const std::span<const std::byte> datagram : datagrams) {
    const Status status = send_one(to, datagram);
    if (status != Status::kOk) {
      return status;
    }
    ++sent;
  }
  return Status::kOk;
}

Status DatagramPort::send_one(const Peer& to, std::span<const std::byte> datagram) noexcept {
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
  scratch_.peer = to;
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
  if (!out_.push(scratch_)) {
    return Status::kWouldBlock;
  }
  // From here on the sender's datagram is on its way; what does not fit any more gets lost.
  if (fault.kind == FaultKind::kRepeat) {
    out_.push(scratch_);
  }
  if (std::exchange(holding_, false)) {
    out_.push(held_);
  }
  return Status::kOk;
}

Result<Received> DatagramPort::receive(std::span<std::byte> space, Duration /*timeout*/) noexcept {
  if (!in_.pop(scratch_)) {
    return fail(Status::kTimeout);
  }
  const std::span<const std::byte> held = scratch_.held();
  std::ranges::copy(held.first(std::min(held.size(), space.size())), space.begin());
  return Received{.bytes = scratch_.size, .from = scratch_.peer, .link = scratch_.link};
}

bool DatagramPort::take_unreachable(Peer& peer) noexcept {
  if (!refusal_) {
    return false;
  }
  peer = *std::exchange(refusal_, std::nullopt);
  return true;
}

std::optional<DatagramPort::Sent> DatagramPort::take_sent() noexcept {
  if (!out_.pop(scratch_)) {
    return std::nullopt;
  }
  return Sent{.to = scratch_.peer, .bytes = scratch_.held()};
}

void DatagramPort::inject(std::span<const std::byte> datagram, const Peer& from,
                          std::uint32_t link) noexcept {
  std::ranges::copy(datagram.first(std::min(datagram.size(), kMaxDatagram)),
                    scratch_.bytes.begin());
  scratch_.size = datagram.size();
  scratch_.peer = from;
  scratch_.link = link;
  if (!in_.push(scratch_)) {
    ++overruns_;
  }
}

bool DatagramPort::Queue::push(const Datagram& datagram) noexcept {
  const int capacity = static_cast<int>(ring.size());
  if (waiting == capacity) {
    return false;
  }
  ring[static_cast<std::size_t>((first + waiting) % capacity)] = datagram;
  ++waiting;
  return true;
}

bool DatagramPort::Queue::pop(Datagram& datagram) noexcept {
  if (waiting == 0) {
    return false;
  }
  datagram = ring[static_cast<std::size_t>(first)];
  first = (first + 1) % static_cast<int>(ring.size());
  --waiting;
  return true;
}

}  // namespace stof::hal::emu

#include "hal/emu/devices/serial_port.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::hal::emu {

void SerialPort::Queue::push(std::byte value) noexcept {
  bytes[(first + size) % bytes.size()] = value;
  ++size;
}

std::size_t SerialPort::Queue::pop(std::span<std::byte> space) noexcept {
  const std::size_t count = std::min(space.size(), size);
  for (std::byte& value : space.first(count)) {
    value = bytes[first];
    first = (first + 1) % bytes.size();
  }
  size -= count;
  return count;
}

SerialPort::SerialPort(std::size_t capacity, std::uint32_t baud, const FaultPlan& faults)
    : baud_(baud), faults_(faults) {
  STOF_CHECK(capacity > 0);
  out_.bytes.resize(capacity);
  in_.bytes.resize(capacity);
}

Result<std::size_t> SerialPort::write(std::span<const std::byte> bytes) noexcept {
  if (lost_) {
    return fail(Status::kDeviceLost);
  }
  const Fault fault = faults_.at(calls_++);
  if (fault.kind == FaultKind::kVanish) {
    lost_ = true;
    return fail(Status::kDeviceLost);
  }
  if (fault.kind == FaultKind::kDelay) {
    return std::size_t{0};
  }
  std::size_t count = std::min(bytes.size(), out_.room());
  if (fault.kind == FaultKind::kTear) {
    count = (count + 1) / 2;
  }
  if (fault.kind == FaultKind::kDrop) {
    return count;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const bool damaged = fault.kind == FaultKind::kCorrupt && i == count / 2;
    out_.push(damaged ? bytes[i] ^ std::byte{0xFF} : bytes[i]);
  }
  if (fault.kind == FaultKind::kRepeat && count > 0 && out_.room() > 0) {
    out_.push(bytes[count - 1]);
  }
  return count;
}

Result<std::size_t> SerialPort::read(std::span<std::byte> space) noexcept {
  if (lost_) {
    return fail(Status::kDeviceLost);
  }
  return in_.pop(space);
}

Status SerialPort::set_baud(std::uint32_t baud) noexcept {
  if (lost_) {
    return Status::kDeviceLost;
  }
  if (baud == 0) {
    return Status::kUnsupported;
  }
  baud_ = baud;
  return Status::kOk;
}

Status SerialPort::reopen() noexcept {
  if (faults_.at(calls_++).kind == FaultKind::kVanish) {
    lost_ = true;
    return Status::kDeviceLost;
  }
  lost_ = false;
  return Status::kOk;
}

void SerialPort::feed(std::span<const std::byte> bytes) noexcept {
  for (const std::byte value : bytes.first(std::min(bytes.size(), in_.room()))) {
    in_.push(value);
  }
}

std::size_t SerialPort::take(std::span<std::byte> space) noexcept { return out_.pop(space); }

}  // namespace stof::hal::emu

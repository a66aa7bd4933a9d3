#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/slots.h"

// Which of two slots a start takes: what the boot loader of a Raspberry Pi reads in autoboot.txt,
// and the rules by which this project writes it. Nothing here knows a disk.
namespace stof::update {

enum class Slot : std::uint8_t { kA, kB };

constexpr Slot other(Slot slot) noexcept { return slot == Slot::kA ? Slot::kB : Slot::kA; }
constexpr char letter(Slot slot) noexcept { return slot == Slot::kA ? 'a' : 'b'; }
constexpr hal::DiskPart part_of(Slot slot) noexcept {
  return slot == Slot::kA ? hal::DiskPart::kSlotA : hal::DiskPart::kSlotB;
}

// Two numbers in a text of one sector. A rename on FAT is not atomic, so the sector is overwritten
// in place, with a text that is as long as the one before and differs in two bytes: whatever part
// of it a power cut leaves, it names slots that are whole.
struct BootChoice {
  Slot usual = Slot::kA;  // any start
  Slot trial = Slot::kB;  // the one start after a restart that asks for it

  friend bool operator==(const BootChoice&, const BootChoice&) = default;
};

inline constexpr std::size_t kSectorBytes = 512;
using Sector = std::span<std::byte, kSectorBytes>;
using ConstSector = std::span<const std::byte, kSectorBytes>;

// None: it is not such a sector.
std::optional<BootChoice> read_choice(ConstSector sector) noexcept;
void write_choice(const BootChoice& choice, Sector sector) noexcept;

// The slot that a start takes. Power that was cut, a watchdog and a panic restart without `trial`.
constexpr Slot started(const BootChoice& choice, bool trial) noexcept {
  return trial ? choice.trial : choice.usual;
}

// How a running slot is settled: every start takes it, and a trial takes the other one. It stands
// there before the other slot is tried, and is written once a trial is confirmed.
constexpr BootChoice settled(Slot running) noexcept {
  return {.usual = running, .trial = other(running)};
}

// Nobody has confirmed the running slot: the next start takes the other one.
constexpr bool on_trial(const BootChoice& choice, Slot running) noexcept {
  return choice.usual != running;
}

}  // namespace stof::update

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "board/board.h"
#include "hal/emu/devices/live_fault.h"

// Faults of the emulated rig while it runs (--fault-socket).
namespace stof::board {

inline constexpr std::array<std::string_view, kDeviceCount> kDeviceNames{"trigger", "stereo",
                                                                         "pmd"};
// In the order of hal::emu::FaultKind.
inline constexpr std::array<std::string_view, 10> kFaultNames{
    "none", "drop", "delay", "repeat", "tear", "corrupt", "vanish", "freeze", "dark", "hang"};

std::optional<Device> device_named(std::string_view name) noexcept;
std::optional<hal::emu::FaultKind> fault_named(std::string_view name) noexcept;

// What each device is made to do, by orders in text. For any thread.
class FaultOrders {
 public:
  // pmd: the rig has that camera.
  explicit FaultOrders(bool pmd) noexcept : pmd_(pmd) {}

  // Of the device; for as long as this lives.
  hal::emu::LiveFault& of(Device device) noexcept {
    return live_[static_cast<std::size_t>(device)];
  }

  // DEVICE:KIND[:EDGES]: that fault from the next edge on, at so many edges, or until it is ended;
  // DEVICE:none ends it; list: nothing changes. The answer is "ok", or "refused: " and what to do;
  // then a line for each device of the rig: DEVICE KIND EDGES KIND,KIND,...: the fault that it has
  // now, for how many edges more ("-": until it is ended, or none), and all that it can have.
  std::string obey(std::string_view order);

 private:
  std::string refusal_or_empty(std::string_view order);

  bool pmd_;
  std::array<hal::emu::LiveFault, kDeviceCount> live_{};
};

}  // namespace stof::board

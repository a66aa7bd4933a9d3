#pragma once

#include <array>
#include <expected>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "board/board.h"
#include "board/emu/scenes.h"
#include "hal/emu/devices/faults.h"

// The emulated board's own command line.
namespace stof::board {

struct EmuOptions {
  SceneOptions scene;  // where there is no dataset
  std::optional<std::filesystem::path> dataset;
  std::optional<std::filesystem::path> tof;
  bool no_tof = false;
  std::optional<std::filesystem::path> truth;
  std::optional<std::filesystem::path> replay;  // recording whose raw pictures are computed again
  bool free_run = false;
  std::string fault_socket{};  // where FaultOrders are taken; empty: nowhere
  std::array<hal::emu::FaultPlan, kDeviceCount> faults;

  const hal::emu::FaultPlan& faults_of(Device device) const {
    return faults[static_cast<std::size_t>(device)];
  }
};

// The PMD recording that lies beside a dataset DIR (PREFIX of PREFIX.json):
// ../../tof/sim/scene/NAME_64x16 or ../../sim/scene/NAME_64x16 from there, NAME being the folder's.
// None: neither is there.
std::optional<std::filesystem::path> recording_beside(const std::filesystem::path& dataset);

// Unknown flags and values without meaning are refused.
std::expected<EmuOptions, Refusal> parse_emu_options(std::span<const std::string_view> arguments);

}  // namespace stof::board

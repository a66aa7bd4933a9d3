#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "board/board.h"
#include "board/config.h"
#include "dsp/base/arena.h"
#include "firmware/memory_shares.h"
#include "firmware/wire/frame/tiles.h"

// All memory of the frame path, reserved at link time for the largest frames the board accepts:
// images, and datagrams on their way out.
namespace stof::firmware {

// Coded depth, width and source on their way out, of larger frames a piece at a time; one image's
// values; what parity adds up; what is signed. The serial line's small pictures and sectors.
constexpr std::size_t coded_bytes(const board::StereoConfig& stereo,
                                  const board::PmdConfig& pmd) noexcept {
  const auto width = static_cast<std::size_t>(stereo.width);
  const auto height = static_cast<std::size_t>(stereo.height);
  const auto samples = 4 * static_cast<std::size_t>(pmd.height);  // rows of them
  const std::size_t depth = wire::raw_tiles(width, height, 2);
  const std::size_t parts = 3 * depth + 3 * wire::raw_tiles(width, height, 1) +
                            wire::raw_tiles(static_cast<std::size_t>(pmd.width), samples, 2) +
                            wire::raw_tiles((width + 1) / 2, (height + 1) / 2, 8);
  return 1250 * (depth + depth / 5) + 100 * parts +
         2 * std::max(width * height, static_cast<std::size_t>(pmd.width) * samples) +
         32 * (width + height) + (std::size_t{1} << 19);
}

inline constexpr std::size_t kMiB = 1 << 20;

struct Workspace {
  alignas(dsp::Arena::kAlign)
      std::array<std::byte, workspace_bytes(board::kConfig.stereo, board::kConfig.pmd)> memory;

  alignas(dsp::Arena::kAlign)
      std::array<std::byte, coded_bytes(board::kConfig.stereo, board::kConfig.pmd)> coded;
};
static_assert(sizeof(Workspace::memory) <= board::kConfig.workspace_limit);

// All else that stofd holds at link time: the serial line's ring (128 KiB), rings of configurations
// and receivers, counters (main.cpp asserts it), and what the C++ library brings.
inline constexpr std::size_t kOtherStaticBytes = std::size_t{256} << 10;

// All static memory of a camera pair of 640x480 with 64 disparities and a PMD camera of 176x144.
inline constexpr std::size_t kVgaLimit = 17 * kMiB;
inline constexpr board::StereoConfig kVga{
    .width = 640, .height = 480, .disparities = 64, .block_width = 64, .block_height = 64};
inline constexpr board::PmdConfig kVgaPmd{.width = 176, .height = 144};
static_assert(workspace_bytes(kVga, kVgaPmd) + coded_bytes(kVga, kVgaPmd) + kOtherStaticBytes <=
              kVgaLimit);

}  // namespace stof::firmware

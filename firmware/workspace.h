#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "board/board.h"
#include "board/config.h"
#include "dsp/base/arena.h"
#include "firmware/wire/frame/tiles.h"

// All memory of the frame path, reserved at link time for the largest frames the board accepts:
// images, and datagrams on their way out.
// Rectifier, Matcher, PmdConverter and Fuser say what they take once they know their parameters
// (dsp::bytes_taken); here stands an upper bound of that for the board's table, proven by tests.
namespace stof::firmware {

constexpr std::size_t pixels(int width, int height) noexcept {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// Two rectified images; for each 400 bytes a patch of 32 x 32 pixels, which tell their places, and
// 16 a row.
constexpr std::size_t rectifier_bytes(const board::StereoConfig& stereo) noexcept {
  return 2 * (pixels(stereo.width, stereo.height) +
              400 * pixels((stereo.width + 31) / 32, (stereo.height + 31) / 32) +
              16 * static_cast<std::size_t>(stereo.height) + 5 * dsp::Arena::kAlign);
}

// Preset `quality`, which takes the most of all presets: eight images; for each column and
// candidate (whole vectors of 16) 4 rows of sums, 96 of costs and paths, and some more; and what
// the largest blocks add to a row of sums. 48 rows are left for a guide and a filter over time.
// With other searches these may take more than that at the board's full size; then they are refused
// at start. threads: each has a search of its own; from two on, two maps are checked at the same
// time.
constexpr std::size_t matcher_bytes(const board::StereoConfig& stereo, int threads = 1) noexcept {
  const auto lanes = static_cast<std::size_t>((stereo.disparities + 15) / 16 * 16);
  const auto columns = static_cast<std::size_t>(stereo.width);
  const auto block = static_cast<std::size_t>(stereo.block_width);
  const std::size_t search = (4 + 48 + 96 + 14) * columns * lanes + 4 * block * lanes +
                             192 * (columns + block) + 64 * lanes + 4096;
  return (threads > 1 ? 17 : 13) * pixels(stereo.width, stereo.height) +
         static_cast<std::size_t>(threads) * search + 8192;
}

// Fourteen maps of up to 4 bytes a pixel, some with a border column on both sides, tables of lights
// and the fixed pattern; rows; constants.
constexpr std::size_t converter_bytes(const board::PmdConfig& pmd) noexcept {
  return 38 * pixels(pmd.width + 2, pmd.height) + 32 * static_cast<std::size_t>(pmd.width) + 8192;
}

// Interval and flags for each stereo pixel; rays and up to four footprints for each PMD
// pixel; intervals by disparity or tangents by column, both in 1/16 px; some rows.
constexpr std::size_t fuser_bytes(const board::StereoConfig& stereo,
                                  const board::PmdConfig& pmd) noexcept {
  return 5 * pixels(stereo.width, stereo.height) + 64 * pixels(pmd.width, pmd.height) +
         16 * (8 + 4) * (static_cast<std::size_t>(stereo.disparities) + 4) +
         (32 + 4 + 16 * 4) * static_cast<std::size_t>(stereo.width) + 8192 + 4 * 2 * 255;
}

// The unwrapper: some 80 bytes a PMD pixel, a coarse picture of the pair's depth, its tables; and
// the means of patches that show whether the rig has drifted.
constexpr std::size_t unwrapper_bytes(const board::StereoConfig& stereo,
                                      const board::PmdConfig& pmd) noexcept {
  return 84 * pixels(pmd.width, pmd.height) + 5 * pixels(stereo.width, stereo.height) / 4 +
         16 * (8 + 4) * (static_cast<std::size_t>(stereo.disparities) + 4) +
         128 * static_cast<std::size_t>(stereo.width) +
         128 * (static_cast<std::size_t>(pmd.width) + static_cast<std::size_t>(pmd.height)) + 16384;
}
constexpr std::size_t monitor_bytes(const board::PmdConfig& pmd) noexcept {
  return 13 * pixels(pmd.width, pmd.height) + 8192;
}

// What frames before tell of each pixel, beside what the search's 48 rows leave.
constexpr std::size_t steady_bytes(const board::StereoConfig& stereo,
                                   const board::PmdConfig& pmd) noexcept {
  return 3 * pixels(stereo.width, stereo.height) + 5 * pixels(pmd.width, pmd.height) + 4096;
}

// Disparity, depth, interval width, source, cause.
constexpr std::size_t image_bytes(const board::StereoConfig& stereo) noexcept {
  return (2 + 2 + 2 + 1 + 1) * pixels(stereo.width, stereo.height) + 5 * dsp::Arena::kAlign;
}

// The most that each part of the frame path takes for a board.
struct Share {
  const char* part;
  std::size_t bytes;
};
constexpr std::array<Share, 8> shares(const board::StereoConfig& stereo,
                                      const board::PmdConfig& pmd) noexcept {
  return {{{"rectifier", rectifier_bytes(stereo)},
           {"matcher", matcher_bytes(stereo)},
           {"converter", converter_bytes(pmd)},
           {"fuser", fuser_bytes(stereo, pmd)},
           {"unwrapper", unwrapper_bytes(stereo, pmd)},
           {"monitor", monitor_bytes(pmd)},
           {"steady", steady_bytes(stereo, pmd)},
           {"images", image_bytes(stereo)}}};
}
constexpr std::size_t workspace_bytes(const board::StereoConfig& stereo,
                                      const board::PmdConfig& pmd) noexcept {
  std::size_t sum = 0;
  for (const Share& share : shares(stereo, pmd)) {
    sum += share.bytes;
  }
  return sum;
}

// Coded depth, width and source on their way out, of larger frames a piece at a time; one image's
// values; what parity adds up. The serial line's small pictures and sectors.
constexpr std::size_t coded_bytes(const board::StereoConfig& stereo,
                                  const board::PmdConfig& pmd) noexcept {
  const auto width = static_cast<std::size_t>(stereo.width);
  const auto height = static_cast<std::size_t>(stereo.height);
  const auto samples = 4 * static_cast<std::size_t>(pmd.height);  // rows of them
  const std::size_t depth = wire::raw_tiles(width, height, 2);
  const std::size_t parts = 3 * depth + 3 * wire::raw_tiles(width, height, 1) +
                            wire::raw_tiles(static_cast<std::size_t>(pmd.width), samples, 2) +
                            wire::raw_tiles((width + 1) / 2, (height + 1) / 2, 8);
  return 1250 * (depth + depth / 4) + 100 * parts +
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

// A camera pair of 640x480 with 64 disparities and a PMD camera of 176x144 leaves room for more in
// 24 MiB, all static memory counted.
inline constexpr board::StereoConfig kVga{
    .width = 640, .height = 480, .disparities = 64, .block_width = 64, .block_height = 64};
inline constexpr board::PmdConfig kVgaPmd{.width = 176, .height = 144};
static_assert(workspace_bytes(kVga, kVgaPmd) + coded_bytes(kVga, kVgaPmd) + kOtherStaticBytes <=
              24 * kMiB);

}  // namespace stof::firmware

#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "board/board.h"
#include "board/config.h"
#include "dsp/base/arena.h"
#include "dsp/fusion/fuser.h"

// All memory of the frame path, reserved at link time for the largest frames the board accepts:
// images, and datagrams on their way out.
// Rectifier, Matcher, Converter and Fuser say what they take once they know their parameters
// (bytes_needed); here stands an upper bound of that for the board's table, proven by tests.
namespace stof::firmware {

constexpr std::size_t pixels(int width, int height) noexcept {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// Two rectified images, places of 6 bytes for each of their pixels.
constexpr std::size_t rectifier_bytes(const board::StereoConfig& stereo) noexcept {
  return 2 * (1 + 6) * pixels(stereo.width, stereo.height) + 10 * dsp::Arena::kAlign;
}

// Preset `quality`, which takes the most of all presets: eight images; for each column and
// candidate (whole vectors of 16) two bytes of 26 rows of sums over regions, one of 96 rows of
// costs and paths, and of some more; and what the largest blocks add to a row of sums. Other
// searches, a guide and a filter over time may take more than that at the board's full size; then
// they are refused at start.
constexpr std::size_t matcher_bytes(const board::StereoConfig& stereo) noexcept {
  const auto lanes = static_cast<std::size_t>((stereo.disparities + 15) / 16 * 16);
  const auto columns = static_cast<std::size_t>(stereo.width);
  const auto block = static_cast<std::size_t>(stereo.block_width);
  return 13 * pixels(stereo.width, stereo.height) + (2 * 26 + 96 + 14) * columns * lanes +
         4 * block * lanes + 192 * (columns + block) + 64 * lanes + 8192;
}

// Ten maps of up to 4 bytes a pixel, some with a border column on both sides, tables of lights and
// the fixed pattern; rows; constants.
constexpr std::size_t converter_bytes(const board::PmdConfig& pmd) noexcept {
  return 30 * pixels(pmd.width + 2, pmd.height) + 32 * static_cast<std::size_t>(pmd.width) + 8192;
}

// Interval and flags for each stereo pixel; rays and up to four footprints for each PMD
// pixel; intervals by disparity or tangents by column, both in 1/16 px; some rows.
constexpr std::size_t fuser_bytes(const board::StereoConfig& stereo,
                                  const board::PmdConfig& pmd) noexcept {
  return 5 * pixels(stereo.width, stereo.height) + 64 * pixels(pmd.width, pmd.height) +
         16 * (8 + 4) * (static_cast<std::size_t>(stereo.disparities) + 4) +
         (32 + 4 + 16 * 4) * static_cast<std::size_t>(stereo.width) + 8192 + 4 * 2 * 255;
}

// What tells the periods of readings apart: some 80 bytes a PMD pixel, a coarse picture of the
// pair's depth, its tables; and the means of patches that show whether the rig has drifted.
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

// Disparity, depth, interval width, source, cause.
constexpr std::size_t image_bytes(const board::StereoConfig& stereo) noexcept {
  return (2 + 2 + 2 + 1 + 1) * pixels(stereo.width, stereo.height) + 5 * dsp::Arena::kAlign;
}

constexpr std::size_t workspace_bytes(const board::StereoConfig& stereo,
                                      const board::PmdConfig& pmd) noexcept {
  return rectifier_bytes(stereo) + matcher_bytes(stereo) + converter_bytes(pmd) +
         fuser_bytes(stereo, pmd) + unwrapper_bytes(stereo, pmd) + monitor_bytes(pmd) +
         image_bytes(stereo);
}

// A coded frame with every stream, raw, on its way out; the serial line's small pictures and
// sectors.
constexpr std::size_t coded_bytes(const board::StereoConfig& stereo,
                                  const board::PmdConfig& pmd) noexcept {
  return 20 * pixels(stereo.width, stereo.height) + 12 * pixels(pmd.width, pmd.height) +
         16 * static_cast<std::size_t>(stereo.width + stereo.height) + (std::size_t{1} << 20);
}

inline constexpr std::size_t kMiB = 1 << 20;

struct Workspace {
  alignas(dsp::Arena::kAlign)
      std::array<std::byte, workspace_bytes(board::kConfig.stereo, board::kConfig.pmd)> memory;

  alignas(dsp::Arena::kAlign)
      std::array<std::byte, coded_bytes(board::kConfig.stereo, board::kConfig.pmd)> coded;
};
static_assert(sizeof(Workspace::memory) <= board::kConfig.workspace_limit);

// A camera pair of 640x480 with 64 disparities and a PMD camera of 176x144 leaves room for more in
// 24 MiB.
inline constexpr board::StereoConfig kVga{
    .width = 640, .height = 480, .disparities = 64, .block_width = 64, .block_height = 64};
static_assert(workspace_bytes(kVga, {.width = 176, .height = 144}) <= 24 * kMiB);

}  // namespace stof::firmware

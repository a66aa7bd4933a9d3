#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "board/config.h"
#include "dsp/base/arena.h"

// The parts of the frame path say what they take once they know their parameters
// (dsp::bytes_taken); here stands an upper bound of that for a board's table, proven by tests.
namespace stof::firmware {

constexpr std::size_t pixels(int width, int height) noexcept {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// What a part takes for good, and for its phase of a frame alone (dsp::ArenaPhase): phases follow
// one another, so that the largest is all that these take together (dsp/depth/depth_maker.cpp).
struct Share {
  const char* part;
  std::size_t lasting;
  std::size_t passing = 0;
  constexpr std::size_t bytes() const noexcept { return lasting + passing; }
};

// Two rectified images; for each 400 bytes a patch of 32 x 32 pixels, which tell their places, and
// 16 a row.
constexpr Share rectifier_share(const board::StereoConfig& stereo) noexcept {
  return {"rectifier", 2 * (pixels(stereo.width, stereo.height) +
                            400 * pixels((stereo.width + 31) / 32, (stereo.height + 31) / 32) +
                            16 * static_cast<std::size_t>(stereo.height) + 5 * dsp::Arena::kAlign)};
}

// Preset `quality`, which takes the most of all presets. Lasting: margins or weak disparities, peak
// ratios. Passing: three images through two phases. The search has for each column and candidate
// (whole vectors of 16) 48 rows of costs, 32 of sums, and 9 of which one is a guide's; sums over
// blocks take 6 rows that are a block longer. The checks have a map and what tells its patches.
// With other searches these may take more at the board's full size; then they are refused at start.
// threads: each has a search of its own; from two on, two maps are checked at the same time.
constexpr Share matcher_share(const board::StereoConfig& stereo, int threads = 1) noexcept {
  const auto lanes = static_cast<std::size_t>((stereo.disparities + 15) / 16 * 16);
  const auto columns = static_cast<std::size_t>(stereo.width);
  const auto block = static_cast<std::size_t>(stereo.block_width);
  const std::size_t image = pixels(stereo.width, stereo.height);
  const std::size_t rows = std::max((48 + 32 + 9) * columns, 6 * (columns + block));
  const std::size_t search = rows * lanes + 64 * (columns + block + lanes) + 4096;
  const std::size_t checks = (2 + (threads > 1 ? 8U : 4U)) * image + 32 * columns;
  return {"matcher", 3 * image + 4096,
          3 * image + std::max(static_cast<std::size_t>(threads) * search, checks) + 4096};
}

// Fourteen maps of up to 4 bytes a pixel, some with a border column on both sides, tables of lights
// and the fixed pattern; rows; constants.
constexpr Share converter_share(const board::PmdConfig& pmd) noexcept {
  return {"converter",
          38 * pixels(pmd.width + 2, pmd.height) + 32 * static_cast<std::size_t>(pmd.width) + 8192};
}

// Rays for each PMD pixel; intervals by disparity or tangents by column, both in 1/16 px.
constexpr std::size_t table_bytes(const board::StereoConfig& stereo,
                                  const board::PmdConfig& pmd) noexcept {
  return 8 * pixels(pmd.width, pmd.height) +
         16 * (8 + 4) * (static_cast<std::size_t>(stereo.disparities) + 4) +
         16 * 4 * static_cast<std::size_t>(stereo.width);
}
// Up to three footprints for each PMD pixel, some rows.
constexpr std::size_t footprint_bytes(const board::PmdConfig& pmd) noexcept {
  return 54 * pixels(pmd.width, pmd.height) + 64 * static_cast<std::size_t>(pmd.width) +
         16 * static_cast<std::size_t>(pmd.height) + 2048;
}

// Passing: interval and flags for each stereo pixel, surfaces of its cells.
constexpr Share fuser_share(const board::StereoConfig& stereo,
                            const board::PmdConfig& pmd) noexcept {
  return {"fuser", table_bytes(stereo, pmd) + 4 * static_cast<std::size_t>(stereo.width) + 6144,
          (5 * 16 + 1) * pixels(stereo.width, stereo.height) / 16 + footprint_bytes(pmd) +
              16 * static_cast<std::size_t>(stereo.width + stereo.height) + 2048};
}

// Passing: some 60 bytes a PMD pixel, a coarse picture of the pair's depth.
constexpr Share unwrapper_share(const board::StereoConfig& stereo,
                                const board::PmdConfig& pmd) noexcept {
  return {"unwrapper",
          table_bytes(stereo, pmd) + pixels(pmd.width, pmd.height + 2) +
              2 * static_cast<std::size_t>(stereo.width + pmd.width) + 4096,
          64 * pixels(pmd.width, pmd.height) + 5 * pixels(stereo.width, stereo.height) / 4 +
              128 * static_cast<std::size_t>(stereo.width) +
              192 * (static_cast<std::size_t>(pmd.width) + static_cast<std::size_t>(pmd.height)) +
              16384};
}
// The means of patches that show whether the rig has drifted, profiles of two pictures.
constexpr Share monitor_share(const board::StereoConfig& stereo,
                              const board::PmdConfig& pmd) noexcept {
  return {"monitor", 10 * pixels(pmd.width, pmd.height) +
                         4 * static_cast<std::size_t>(stereo.width + stereo.height) + 4096};
}

// Candidates of each pixel, tables; passing: intervals of all pixels, readings.
constexpr Share guide_share(const board::StereoConfig& stereo,
                            const board::PmdConfig& pmd) noexcept {
  return {"guide",
          2 * pixels(stereo.width, stereo.height) + 8 * pixels(pmd.width, pmd.height) + 18432,
          9 * pixels(stereo.width, stereo.height) + 7 * pixels(pmd.width, pmd.height) +
              footprint_bytes(pmd) + 4 * static_cast<std::size_t>(stereo.width) + 4096};
}

// What frames before tell of each pixel, and of each PMD pixel.
constexpr Share past_share(const board::StereoConfig& stereo,
                           const board::PmdConfig& pmd) noexcept {
  return {"past", 11 * pixels(stereo.width, stereo.height) +
                      pixels(stereo.width + 8, stereo.height + 8) / 7 +
                      9 * pixels(pmd.width, pmd.height) +
                      8 * static_cast<std::size_t>(stereo.width + pmd.width) + 4096};
}

// Disparity, depth, interval width, source, cause.
constexpr Share image_share(const board::StereoConfig& stereo) noexcept {
  return {"images",
          (2 + 2 + 2 + 1 + 1) * pixels(stereo.width, stereo.height) + 5 * dsp::Arena::kAlign};
}

// The most that each part of the frame path takes for a board.
constexpr std::array<Share, 9> shares(const board::StereoConfig& stereo,
                                      const board::PmdConfig& pmd) noexcept {
  return {rectifier_share(stereo),  matcher_share(stereo),        converter_share(pmd),
          fuser_share(stereo, pmd), unwrapper_share(stereo, pmd), monitor_share(stereo, pmd),
          guide_share(stereo, pmd), past_share(stereo, pmd),      image_share(stereo)};
}
constexpr std::size_t workspace_bytes(const board::StereoConfig& stereo,
                                      const board::PmdConfig& pmd) noexcept {
  std::size_t lasting = 0;
  std::size_t passing = 0;
  for (const Share& share : shares(stereo, pmd)) {
    lasting += share.lasting;
    passing = std::max(passing, share.passing);
  }
  return lasting + passing + dsp::Arena::kAlign;
}

}  // namespace stof::firmware

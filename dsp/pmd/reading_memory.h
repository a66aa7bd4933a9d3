#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// Whether a reading is the one that was seen there before: within 3 sigma and a 64th.
constexpr bool is_same_reading(QuarterMm now, QuarterMm sigma, QuarterMm before) noexcept {
  const int apart = now > before ? now - before : before - now;
  return apart <= 3 * sigma + now / 64;
}

// Readings of the frame before, of a standing PMD camera. A reading whose modulation ratio lies
// about the limit comes and goes by its noise. Where it was accepted before, it stays down to five
// eighths of that limit, as long as it is the same reading, and of the same brightness: this tells
// sooner than the distance that something else came before the pixel. Nothing stays where, within
// kQuietFrames, two pixels of one of the 3x3 cells around it have changed their brightness.
class ReadingMemory {
 public:
  static constexpr int kCell = 4;  // pixels a side
  static constexpr int kQuietFrames = 6;

  // ratio_q16: twice the least ratio, as in PhaseLimits.
  ReadingMemory(int width, int height, std::uint32_t ratio_q16, Arena& arena) noexcept;

  void forget() noexcept;

  // Once a frame, before its rows.
  void begin_frame() noexcept;
  // For each row: first takes kPmdLowRatio from what may stay. ratio: 1/256; offset: as PmdMaps has
  // it.
  void admit(int y, std::span<const std::uint8_t> ratio, std::span<const std::uint16_t> offset,
             std::span<std::uint8_t> flags) noexcept;
  // Then, when distances are known, gives it back to what is another reading, and remembers.
  void settle(int y, std::span<std::uint8_t> flags, std::span<QuarterMm> distance,
              std::span<QuarterMm> sigma) noexcept;

 private:
  void count_changes(int y) noexcept;

  int least_ratio_;
  ImageView<QuarterMm> distance_;  // kNoDepth: none
  ImageView<std::uint16_t> offset_;
  std::span<std::uint8_t> changed_;   // of the row: its brightness is another than before
  std::span<std::uint8_t> standing_;  // of the row: its cells are quiet
  std::span<std::uint8_t> admitted_;  // of the row
  bool admits_ = false;               // one of the row
  ImageView<std::uint8_t> changes_;   // of each cell, in this frame
  ImageView<std::uint8_t> quiet_;     // frames since the last around each cell
};

}  // namespace stof::dsp

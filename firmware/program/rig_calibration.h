#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "board/config.h"
#include "dsp/calib/calibration.h"
#include "firmware/settings/text/paged_writer.h"

// Which calibration files suit a rig: the same rules at start and when one is installed.
namespace stof::firmware {

// What a file has to suit.
struct RigNeeds {
  const board::Config* board = nullptr;
  dsp::Pinhole left{};  // sizes of the pictures
  dsp::Pinhole pmd{};   // 0x0: no PMD camera
  // That the PMD camera has whatever a file says; none: as the file says.
  std::optional<dsp::Hertz> modulation{};
};

// Pixels of the fixed pattern that a board has room for.
std::size_t pattern_pixels(const board::Config& board) noexcept;
// Bytes of the longest file that a board takes.
std::size_t most_calibration_bytes(const board::Config& board) noexcept;

// The calibration in a file, complete() and without problem(); its fixed pattern is stored in
// `pattern` (pattern_pixels()), also where it is refused. None: `why` says in one line what is
// wrong and what to do. No heap.
std::optional<dsp::Calibration> read_rig_calibration(std::span<const std::byte> file,
                                                     const RigNeeds& rig,
                                                     std::span<std::int16_t> pattern,
                                                     settings::PagedWriter& why) noexcept;

}  // namespace stof::firmware

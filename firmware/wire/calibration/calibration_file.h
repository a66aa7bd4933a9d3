#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "dsp/calib/calibration.h"

// The calibration of a rig as a file: every bit of dsp::Calibration, with version and CRC-32C.
// The bytes are described in docs/WIRE.md. Files of version 1, which knew neither raw nor
// converging pairs, and of version 2, which knew one modulation frequency and no light beside the
// lens, are read too; what is written is always the newest version.
namespace stof::wire {

inline constexpr std::uint16_t kCalibrationFileVersion = 3;

// Bytes of the file.
std::size_t calibration_file_bytes(const dsp::Calibration& calibration) noexcept;

// Of the longest file with a fixed pattern of so many pixels.
std::size_t most_calibration_file_bytes(std::size_t pattern_pixels) noexcept;

// Of a file that decode_calibration_file() takes: its CRC, the same for the same bytes alone. It
// tells calibrations apart on the wire. 0: shorter than any file.
std::uint32_t calibration_fingerprint(std::span<const std::byte> file) noexcept;

// Returns how many bytes of `out` were written. kTooLarge: out is smaller than
// calibration_file_bytes().
Result<std::size_t> encode_calibration_file(const dsp::Calibration& calibration,
                                            std::span<std::byte> out) noexcept;

// Exactly what was encoded; doubles keep their bits. The fixed pattern is stored in `fixed_pattern`
// and the result borrows it from there (it may be larger than needed, and empty for a file
// without). kCorrupt: not such a file, cut short, or damaged. kUnsupported: a later version.
// kTooLarge: the file's fixed pattern does not fit the space.
// Whether the numbers make sense is for dsp::problem() to say.
Result<dsp::Calibration> decode_calibration_file(std::span<const std::byte> file,
                                                 std::span<std::int16_t> fixed_pattern) noexcept;

}  // namespace stof::wire

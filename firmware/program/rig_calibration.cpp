#include "firmware/program/rig_calibration.h"

#include "firmware/wire/calibration/calibration_file.h"

namespace stof::firmware {
namespace {

using settings::PagedWriter;

void write_size(const dsp::Pinhole& lens, PagedWriter& out) noexcept {
  out << lens.width << 'x' << lens.height;
}

bool same_size(const dsp::Pinhole& a, const dsp::Pinhole& b) noexcept {
  return a.width == b.width && a.height == b.height;
}

void refuse_file(Status why, const board::Config& board, PagedWriter& out) noexcept {
  switch (why) {
    case Status::kUnsupported:
      out << "a calibration of a later version: export it again for version "
          << wire::kCalibrationFileVersion;
      return;
    case Status::kTooLarge:
      out << "its PMD camera is larger than this board's " << board.pmd.width << 'x'
          << board.pmd.height << ": use the calibration of this rig";
      return;
    default:
      out << "not a calibration file, or damaged: export it again";
  }
}

bool suits(const dsp::Calibration& calibration, const RigNeeds& rig, PagedWriter& why) noexcept {
  const dsp::Pinhole& left = calibration.stereo.left;
  const dsp::Pinhole& pmd = calibration.pmd.lens;
  if (!same_size(left, rig.left) || !same_size(pmd, rig.pmd)) {
    why << "made for cameras of ";
    write_size(left, why);
    why << " and ";
    write_size(pmd, why);
    why << ", these have ";
    write_size(rig.left, why);
    why << " and ";
    write_size(rig.pmd, why);
    why << ": use the calibration of this rig";
    return false;
  }
  const std::uint32_t calibrated = calibration.pmd.frequency.modulation.value;
  if (rig.modulation && rig.pmd.width > 0 && calibrated != rig.modulation->value) {
    why << "of a PMD camera that modulates with " << calibrated << " Hz, this board's does with "
        << rig.modulation->value << " Hz: use the calibration of this rig";
    return false;
  }
  return true;
}

}  // namespace

std::size_t pattern_pixels(const board::Config& board) noexcept {
  return static_cast<std::size_t>(board.pmd.width) * static_cast<std::size_t>(board.pmd.height);
}

std::size_t most_calibration_bytes(const board::Config& board) noexcept {
  return wire::most_calibration_file_bytes(pattern_pixels(board));
}

std::optional<dsp::Calibration> read_rig_calibration(std::span<const std::byte> file,
                                                     const RigNeeds& rig,
                                                     std::span<std::int16_t> pattern,
                                                     PagedWriter& why) noexcept {
  Result<dsp::Calibration> read = wire::decode_calibration_file(file, pattern);
  if (!read) {
    refuse_file(read.error(), *rig.board, why);
    return std::nullopt;
  }
  if (const char* const wrong = dsp::complete(read->stereo); *wrong != '\0') {
    why << wrong << ": calibrate the rig anew";
    return std::nullopt;
  }
  if (!suits(*read, rig, why)) {
    return std::nullopt;
  }
  if (const char* const wrong = dsp::problem(*read); *wrong != '\0') {
    why << wrong << ": calibrate the rig anew";
    return std::nullopt;
  }
  return *read;
}

}  // namespace stof::firmware

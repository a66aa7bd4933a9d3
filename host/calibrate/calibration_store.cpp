#include "host/calibrate/calibration_store.h"

#include "dataset/files/file.h"
#include "dataset/files/json_fields.h"
#include "firmware/wire/calibration/calibration_file.h"
#include "posix/replaced_file.h"

namespace stof::host {

using dataset::refuse;

namespace {

// A fixed pattern of 4096 x 4096 pixels, and what is beside it.
constexpr std::size_t kMaxBytes = std::size_t{1} << 26;

// Empty, or what cannot be computed with. The file of a PMD camera alone has no baseline.
std::string problem_of_file(dsp::Calibration calibration) {
  if (const char* const why = dsp::complete(calibration.stereo); *why != '\0') {
    return why;
  }
  return dataset::problem_of(calibration, calibration.stereo.baseline_m != 0);
}

}  // namespace

dataset::Loaded<StoredCalibration> read_calibration(const std::filesystem::path& file) {
  const dataset::Loaded<std::string> text = dataset::read_whole(file, kMaxBytes);
  if (!text) {
    return std::unexpected(text.error());
  }
  StoredCalibration stored;
  // No pattern has more elements than the file has bytes.
  stored.fixed_pattern.resize(text->size() / sizeof(std::int16_t));
  const Result<dsp::Calibration> decoded = wire::decode_calibration_file(
      std::as_bytes(std::span(text->data(), text->size())), stored.fixed_pattern);
  if (!decoded) {
    return decoded.error() == Status::kUnsupported
               ? refuse(file, "a calibration of a later version", "use a later stof")
               : refuse(file, "not a calibration file, or damaged", "export it again");
  }
  if (const std::string why = problem_of_file(*decoded); !why.empty()) {
    return refuse(file, why, "calibrate the rig anew");
  }
  stored.calibration = *decoded;
  return stored;
}

dataset::Loaded<StoredCalibration> read_pmd_calibration(const std::filesystem::path& file) {
  dataset::Loaded<StoredCalibration> stored = read_calibration(file);
  if (stored && stored->calibration.pmd.lens.width == 0) {
    return refuse(file, "holds no PMD camera", "give what stof calib pmd wrote");
  }
  return stored;
}

std::expected<void, dataset::Problem> write_calibration(const std::filesystem::path& file,
                                                        const dsp::Calibration& calibration) {
  std::vector<std::byte> bytes(wire::calibration_file_bytes(calibration));
  if (!wire::encode_calibration_file(calibration, bytes)) {
    return refuse(file, "too large for a calibration file", "use a smaller sensor");
  }
  constexpr mode_t kReadable = 0666;  // as the user's mask leaves it
  const int error = posix::replace_file(file.string(), bytes, kReadable);
  return error == 0 ? std::expected<void, dataset::Problem>()
                    : dataset::refuse_to_write(file, error);
}

}  // namespace stof::host

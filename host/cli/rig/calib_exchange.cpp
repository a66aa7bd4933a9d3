#include <cstdio>

#include "dataset/files/file.h"
#include "host/calibrate/calibration_store.h"
#include "host/calibrate/rig/exchange/exchange.h"
#include "host/calibrate/rig/target/target_calibration.h"
#include "host/cli/calib_files.h"
#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/rig/calib_rig.h"

namespace stof::host {
namespace {

dsp::RawPair read_pair_of(const CalibExchangeOptions& options) {
  std::vector<NamedText> texts;
  texts.reserve(options.files.size());
  for (const std::filesystem::path& file : options.files) {
    texts.push_back(value_or_fail(read_text(file)));
  }
  if (options.format == "ros") {
    return value_or_fail(parse_ros(texts));
  }
  if (options.format == "kalibr") {
    if (texts.size() != 1) {
      throw Failure(Exit::kBadInput, "import kalibr: takes one file: give the camchain");
    }
    return value_or_fail(parse_kalibr(texts.front()));
  }
  const bool sized = options.size.size() == 2;
  return value_or_fail(
      parse_opencv(texts, sized ? options.size[0] : 0, sized ? options.size[1] : 0));
}

// Nothing is lost but an older file of this format.
void need_format_out(const std::filesystem::path& out, const CalibExchangeOptions& options) {
  const auto has = [](std::string_view bytes, std::string_view word) {
    return bytes.find(word) != std::string_view::npos;
  };
  need_out_of_kind(
      out, "--out", {options.start}, "file of " + options.format, [&](std::string_view bytes) {
        if (options.format == "ros") {
          return has(bytes, "camera_matrix") && has(bytes, "projection_matrix");
        }
        return options.format == "kalibr" ? has(bytes, "cam0:") : has(bytes, "opencv-matrix");
      });
}

}  // namespace

void calib_import(const CalibExchangeOptions& options) {
  need_calibration_out(options.out, options.files);
  const dsp::RawPair pair = read_pair_of(options);
  StoredCalibration start;
  if (!options.start.empty()) {
    start = value_or_fail(read_calibration(options.start));
  }
  const dsp::Calibration rig = with_pair(start.calibration, pair);
  value_or_end(write_calibration(options.out, rig));
  if (options.json) {
    say_json({{"file", options.out.string()},
              {"format", options.format},
              {"width", pair.left.width},
              {"height", pair.left.height},
              {"baseline_m", rig.stereo.baseline_m},
              {"rectified_focal_px", rig.stereo.left.fx}});
    return;
  }
  std::printf("%s: %dx%d, baseline %.4f m, rectified focal length %.2f px\n", options.out.c_str(),
              pair.left.width, pair.left.height, rig.stereo.baseline_m, rig.stereo.left.fx);
}

void calib_export(const CalibExchangeOptions& options) {
  const StoredCalibration stored = value_or_fail(read_calibration(options.start));
  const std::optional<dsp::RawPair>& pair = stored.calibration.stereo.raw;
  if (!pair) {
    throw Failure(Exit::kBadInput, options.start.string() +
                                       ": has no raw pair, which these formats hold: calibrate it "
                                       "with stof calib stereo --target");
  }
  std::vector<std::string> files{options.out.string()};
  if (options.format == "ros") {
    need_folder(options.out, "--out");
    files = {(options.out / "left.yaml").string(), (options.out / "right.yaml").string()};
    for (const std::string& file : files) {
      need_format_out(file, options);
    }
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    value_or_end(dataset::write_whole(files[0], ros_text(*pair, false)));
    value_or_end(dataset::write_whole(files[1], ros_text(*pair, true)));
  } else {
    need_its_folder(options.out, "--out");
    need_format_out(options.out, options);
    const std::string text =
        options.format == "kalibr" ? value_or_fail(kalibr_text(*pair)) : opencv_text(*pair);
    value_or_end(dataset::write_whole(options.out, text));
  }
  if (options.json) {
    say_json(
        {{"calibration", options.start.string()}, {"format", options.format}, {"files", files}});
    return;
  }
  std::printf("%s\n", options.out.c_str());
}

}  // namespace stof::host

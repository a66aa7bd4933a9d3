#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/image.h"
#include "dsp/calib/calibration.h"

// Calibrations of pairs in the files of others: ROS CameraInfo, Kalibr camchain, OpenCV
// FileStorage, each YAML. Lenses and poses alone: none of them knows a PMD camera. All three count
// pixels from the centre of the first one and mean by the transform of the second camera that of
// points from the first into it, as dsp::RawPair does.
namespace stof::host {

enum class ExchangeFormat : std::uint8_t { kRos, kKalibr, kOpenCv };

// A calibration that a file holds. Numbers come back to the last bit where the writer is ours.
// Refused, each with the file, the line, and why:
//   models other than a pinhole with k1 k2 p1 p2 (k3): rational, thin prism, equidistant, omni, ...
//   what is no YAML, what is missing, and matrices of another size.

// ROS CameraInfo: a file for each eye (`left`, `right`). The pose between both is in R and P of the
// pair: of the projection matrices the right one's P[3] = -fx b.
dataset::Loaded<dsp::RawPair> read_ros(const std::filesystem::path& left,
                                       const std::filesystem::path& right);
// cam0 is the left, cam1 the right one (T_cn_cnm1).
dataset::Loaded<dsp::RawPair> read_kalibr(const std::filesystem::path& file);
// M1 D1 M2 D2 R T in one file or two (OpenCV's stereo_calib: intrinsics.yml and extrinsics.yml),
// also as cameraMatrix1 ...; image_width, image_height, or else size.
dataset::Loaded<dsp::RawPair> read_opencv(const std::vector<std::filesystem::path>& files,
                                          int width, int height);

// The text of such files. ROS takes two, left and right.
std::string ros_text(const dsp::RawPair& rig, bool right);
// One line where Kalibr has no place for it: k3.
dataset::Loaded<std::string> kalibr_text(const dsp::RawPair& rig);
std::string opencv_text(const dsp::RawPair& rig);

}  // namespace stof::host

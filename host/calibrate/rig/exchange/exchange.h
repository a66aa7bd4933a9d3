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

// The bytes of a file, and how messages call it.
struct NamedText {
  std::filesystem::path file;
  std::string text;
};
dataset::Loaded<NamedText> read_text(const std::filesystem::path& file);

// A calibration that texts hold. Numbers come back to the last bit where the writer is ours.
// Refused in one line, with the file, its line, and why:
//   models other than a pinhole with k1 k2 p1 p2 (k3): rational, thin prism, equidistant, omni, ...
//   what is none of these formats, what is missing or there twice, and matrices of another size.

// ROS CameraInfo, YAML or INI (camera_calibration's ost.txt): a text for each eye, left first, or
// one INI that holds both. The pose between both is in R and P of the pair: of the projection
// matrices the right one's P[3] = -fx b.
dataset::Loaded<dsp::RawPair> parse_ros(const std::vector<NamedText>& texts);
// Kalibr's camchain: cam0 is the left, cam1 the right one (T_cn_cnm1).
dataset::Loaded<dsp::RawPair> parse_kalibr(const NamedText& text);
// OpenCV's FileStorage, YAML or JSON: M1 D1 M2 D2 R T in one text or two (stereo_calib's
// intrinsics.yml and extrinsics.yml), also as cameraMatrix1 ...; image_width, image_height, or else
// the size told.
dataset::Loaded<dsp::RawPair> parse_opencv(const std::vector<NamedText>& texts, int width,
                                           int height);

// The text of such files. ROS takes two, left and right.
std::string ros_text(const dsp::RawPair& rig, bool right);
// One line where Kalibr has no place for it: k3.
dataset::Loaded<std::string> kalibr_text(const dsp::RawPair& rig);
std::string opencv_text(const dsp::RawPair& rig);

}  // namespace stof::host

#include "tests/fuzz/import_file.h"

// ROS CameraInfo, YAML or INI. First byte: 0, one text with both cameras; 1, 2: the left or the
// right one, the other is good.
namespace stof {
namespace {

constexpr const char* kGood = R"(image_width: 64
image_height: 48
distortion_model: plumb_bob
camera_matrix: {rows: 3, cols: 3, data: [50, 0, 32, 0, 50, 24, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [50, 0, 32, )";

host::NamedText good(bool right) {
  return {"good", std::string(kGood) + (right ? "-5" : "0") + ", 0, 50, 24, 0, 0, 0, 1, 0]}\n"};
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  const host::NamedText text = text_of(input.subspan(1));
  switch (std::to_integer<unsigned>(input[0]) % 3) {
    case 0:
      judge(host::parse_ros({text}));
      break;
    case 1:
      judge(host::parse_ros({text, good(true)}));
      break;
    default:
      judge(host::parse_ros({good(false), text}));
      break;
  }
}

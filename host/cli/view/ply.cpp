#include "host/cli/view/ply.h"

#include <bit>

#include "dataset/files/file.h"

namespace stof::host {
namespace {

void append_float(std::string& bytes, float value) {
  std::uint32_t word = std::bit_cast<std::uint32_t>(value);
  for (int i = 0; i < 4; ++i, word >>= 8) {
    bytes.push_back(static_cast<char>(word & 0xFFU));
  }
}

}  // namespace

std::expected<void, dataset::Problem> write_ply(const std::filesystem::path& file,
                                                const std::vector<client::Point>& cloud) {
  std::string bytes =
      "ply\n"
      "format binary_little_endian 1.0\n"
      "comment metres in the left camera: x right, y down, z forward; sigma is of z\n"
      "comment source: 1 stereo, 2 PMD, 3 both, 4 resolved\n"
      "element vertex " +
      std::to_string(cloud.size()) +
      "\n"
      "property float x\n"
      "property float y\n"
      "property float z\n"
      "property float sigma\n"
      "property uchar source\n"
      "end_header\n";
  for (const client::Point& point : cloud) {
    for (const float value : {point.x, point.y, point.z, point.z_width / 4}) {
      append_float(bytes, value);
    }
    bytes.push_back(static_cast<char>(point.source));
  }
  return dataset::write_whole(file, bytes);
}

}  // namespace stof::host

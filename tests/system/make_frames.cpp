#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "board/emu/scenes.h"
#include "board/emu/write_pair.h"
#include "firmware/wire/calibration/calibration_file.h"

// stof_system_frames DIR COUNT WxH WxH: what the cameras of the system test see. Exposures 1 to
// COUNT of a scene in which somebody walks, each a dataset folder DIR/0 on with its PMD recording
// DIR/0/pmd; and DIR/rig.cal, the calibration of all of them. The sizes are those of the stereo and
// of the PMD pictures.
namespace {

namespace board = stof::board;

constexpr int kBadInput = 2;

int complain(const std::string& line) {
  std::fprintf(stderr, "stof_system_frames: %s\n", line.c_str());
  return kBadInput;
}

int write_pairs(const std::filesystem::path& dir, int count, std::string_view stereo,
                std::string_view pmd) {
  for (int k = 0; k < count; ++k) {
    const std::string folder = (dir / std::to_string(k)).string();
    const std::string exposure = std::to_string(k + 1);
    const std::vector<std::string_view> arguments{
        folder, "--scene", "walking", "--size", stereo, "--pmd", pmd, "--exposure", exposure};
    if (const int code = board::write_pair(arguments); code != 0) {
      return code;
    }
  }
  return 0;
}

int write_calibration(const std::filesystem::path& file, std::string_view stereo,
                      std::string_view pmd) {
  board::SceneOptions options;
  options.name = "walking";
  for (const auto& [flag, value] :
       {std::pair{std::string_view("--size"), stereo}, std::pair{std::string_view("--pmd"), pmd}}) {
    if (const auto taken = board::take_scene_flag(flag, value, options); !taken) {
      return complain(taken.error());
    }
  }
  const board::SceneWorld world = board::render_world(options);
  std::vector<std::byte> bytes(stof::wire::calibration_file_bytes(world.imagery->calibration()));
  const auto written = stof::wire::encode_calibration_file(world.imagery->calibration(), bytes);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  return written && out ? 0
                        : complain(file.string() +
                                   ": cannot be written: check the folder and its "
                                   "permissions");
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  const int count = arguments.size() == 4 ? std::atoi(arguments[1].c_str()) : 0;
  if (count < 1 || count > 1000) {
    return complain("takes DIR COUNT WxH WxH, COUNT from 1 to 1000");
  }
  const std::filesystem::path dir = arguments[0];
  if (const int code = write_pairs(dir, count, arguments[2], arguments[3]); code != 0) {
    return code;
  }
  return write_calibration(dir / "rig.cal", arguments[2], arguments[3]);
}

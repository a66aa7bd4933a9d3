#include <array>
#include <utility>

#include "dsp/base/check.h"
#include "host/cli/rig/calib_rig.h"

namespace stof::host {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kExamples{{
    {"stereo", "--live 192.168.1.20 --board charuco:12x9:0.03992 --out rig.cal"},
    {"extrinsics", "--live 192.168.1.20 --calibration rig.cal --out rig.cal"},
    {"check", "--live 192.168.1.20 --calibration rig.cal"},
    {"import", "kalibr camchain.yaml --out rig.cal"},
    {"export", "ros rig.cal --out camera_info"},
    {"target", "--board charuco:12x9:0.04 --paper a2 --out board.pdf"},
}};

}  // namespace

std::string calib_rig_example(std::string_view command) {
  for (const auto& [name, words] : kExamples) {
    if (name == command) {
      return "stof calib " + std::string(name) + " " + std::string(words);
    }
  }
  STOF_CHECK(false);
}

}  // namespace stof::host

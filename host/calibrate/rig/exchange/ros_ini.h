#pragma once

#include <string_view>
#include <vector>

#include "host/calibrate/rig/exchange/exchange.h"

// The INI files of ROS (camera_calibration's ost.txt, camera_calibration_parsers): a section
// [image] with width and height, then one for each camera, in which a name stands alone in its line
// and its numbers in those that follow.
namespace stof::host {

struct IniNumbers {
  int line = 0;  // of the name; 0: not there
  std::vector<double> numbers{};
};

struct IniCamera {
  int line = 0;  // of its section
  int width = 0;
  int height = 0;
  IniNumbers matrix{};         // 9
  IniNumbers distortion{};     // at least 1
  IniNumbers rectification{};  // 9
  IniNumbers projection{};     // 12
};

// Whether the first line that says something begins a section, as YAML of names never does.
bool is_ini(std::string_view text);

// One line with the number of the line where something is missing, unknown, there twice or no
// number. Sections [externals] are left alone.
dataset::Loaded<std::vector<IniCamera>> parse_ini(const NamedText& text);

}  // namespace stof::host

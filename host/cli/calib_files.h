#pragma once

#include <filesystem>
#include <vector>

// The files that `stof calib` writes: found wrong before anything is read or asked of a sensor.
namespace stof::host {

// `out` has a name, lies in a folder that can be written to, is none itself, and is none of
// `inputs`. Throws Failure, bad input; flag: that
// named it, such as "--out".
void need_other_file(const std::filesystem::path& out, const char* flag,
                     const std::vector<std::filesystem::path>& inputs);

// The same of --out, and nothing but a calibration is lost: whatever else is there stays.
void need_calibration_out(const std::filesystem::path& out,
                          const std::vector<std::filesystem::path>& inputs = {});

}  // namespace stof::host

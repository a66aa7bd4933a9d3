#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
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

// The folder that `out` lies in is there.
void need_its_folder(const std::filesystem::path& out, const char* flag);

// As need_other_file(), and what is there is lost only where `is_one` says that its bytes are of
// that kind, such as "PDF". Empty files hold nothing that could be lost.
void need_out_of_kind(const std::filesystem::path& out, const char* flag,
                      const std::vector<std::filesystem::path>& inputs, const std::string& kind,
                      const std::function<bool(std::string_view)>& is_one);

}  // namespace stof::host

#include "host/cli/calib_files.h"

#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "host/cli/failure.h"
#include "host/cli/output.h"

namespace stof::host {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const char* flag, const char* what) {
  throw Failure(Exit::kBadInput, std::string(flag) + " " + file.string() + ": " + what);
}

// Empty files hold nothing that could be lost.
bool holds_something_else(const std::filesystem::path& file) {
  constexpr std::string_view kBegins = "STOFCAL";
  std::ifstream in(file, std::ios::binary);
  std::array<char, kBegins.size()> begins{};
  in.read(begins.data(), static_cast<std::streamsize>(begins.size()));
  const auto count = static_cast<std::size_t>(in.gcount());
  return count > 0 && std::string_view(begins.data(), count) != kBegins;
}

}  // namespace

void need_other_file(const std::filesystem::path& out, const char* flag,
                     const std::vector<std::filesystem::path>& inputs) {
  if (out.empty()) {
    throw Failure(Exit::kBadInput, std::string(flag) + ": names no file: give one");
  }
  std::error_code error;
  if (std::filesystem::is_directory(out, error)) {
    refuse(out, flag, "is a folder: give a file");
  }
  if (!std::filesystem::exists(out, error)) {
    need_folder(out.parent_path(), flag);
  }
  for (const std::filesystem::path& input : inputs) {
    if (std::filesystem::equivalent(out, input, error) && !error) {
      refuse(out, flag, "is what is read, which would be lost: give another file");
    }
  }
}

void need_calibration_out(const std::filesystem::path& out,
                          const std::vector<std::filesystem::path>& inputs) {
  need_other_file(out, "--out", inputs);
  std::error_code error;
  if (std::filesystem::is_regular_file(out, error) && holds_something_else(out)) {
    refuse(out, "--out", "is there and is no calibration: give another file, or remove this one");
  }
}

}  // namespace stof::host

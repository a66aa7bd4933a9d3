#include "host/cli/calib_files.h"

#include <fstream>
#include <system_error>

#include "host/cli/failure.h"
#include "host/cli/output.h"

namespace stof::host {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const char* flag, const char* what) {
  throw Failure(Exit::kBadInput, std::string(flag) + " " + file.string() + ": " + what);
}

// As much of it as tells what it is.
std::string begin_of(const std::filesystem::path& file) {
  constexpr std::size_t kEnough = 64 * 1024;
  std::ifstream in(file, std::ios::binary);
  std::string begin(kEnough, '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  return begin;
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

void need_its_folder(const std::filesystem::path& out, const char* flag) {
  std::error_code error;
  if (out.has_parent_path() && !std::filesystem::is_directory(out.parent_path(), error)) {
    refuse(out, flag, "its folder is not there: make it, or give another file");
  }
}

void need_out_of_kind(const std::filesystem::path& out, const char* flag,
                      const std::vector<std::filesystem::path>& inputs, const std::string& kind,
                      const std::function<bool(std::string_view)>& is_one) {
  need_other_file(out, flag, inputs);
  std::error_code error;
  if (!std::filesystem::is_regular_file(out, error)) {
    return;
  }
  const std::string begin = begin_of(out);
  if (!begin.empty() && !is_one(begin)) {
    const std::string what =
        "is there and is no " + kind + ": give another file, or remove this one";
    refuse(out, flag, what.c_str());
  }
}

void need_calibration_out(const std::filesystem::path& out,
                          const std::vector<std::filesystem::path>& inputs) {
  need_out_of_kind(out, "--out", inputs, "calibration",
                   [](std::string_view bytes) { return bytes.starts_with("STOFCAL"); });
}

}  // namespace stof::host

#include "host/cli/output.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

#include "host/cli/failure.h"

namespace stof::host {
namespace {

[[noreturn]] void refuse_output() { throw Failure(Exit::kFailure, unwritten_text(errno)); }

[[noreturn]] void refuse_path(const char* flag, const std::filesystem::path& path,
                              const char* what) {
  throw Failure(Exit::kBadInput, std::string(flag) + " " + path.string() + ": " + what);
}

bool may_write(const std::filesystem::path& path) {
  return ::access(path.empty() ? "." : path.c_str(), W_OK) == 0;
}

}  // namespace

const char* unwritten_text(int error) noexcept {
  return error == EPIPE ? "its output cannot be written any more: whoever read it has gone"
                        : "its output cannot be written: make room, or send it elsewhere";
}

void say_aside(const std::string& line) {
  std::fprintf(stderr, "%s\n", line.c_str());
  std::fflush(stderr);
}

void say_text(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    refuse_output();
  }
}

void say(const std::string& line) { say_text(line + "\n"); }

void need_output() {
  struct stat kind{};
  if (::fstat(STDOUT_FILENO, &kind) != 0) {
    refuse_output();
  }
  // Nothing written tells of a device that takes nothing. A socket could take it for a message.
  if (!S_ISSOCK(kind.st_mode) && ::write(STDOUT_FILENO, "", 0) < 0 && errno != EAGAIN) {
    refuse_output();
  }
}

void need_folder(const std::filesystem::path& folder, const char* flag) {
  std::error_code error;
  std::filesystem::path there = folder;
  // What would be made below the first part that is there.
  while (!there.empty() &&
         !std::filesystem::exists(std::filesystem::symlink_status(there, error))) {
    if (there == there.parent_path()) {
      break;
    }
    there = there.parent_path();
  }
  if (!there.empty() && !std::filesystem::is_directory(there, error)) {
    refuse_path(flag, folder,
                there == folder ? "is not a folder: give another one"
                                : "lies below what is not a folder: give another one");
  }
  if (!may_write(there)) {
    refuse_path(flag, folder, "cannot be written to: check its permissions and its disk");
  }
}

void need_file(const std::filesystem::path& file, const char* flag) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::symlink_status(file, error);
  if (!std::filesystem::exists(status)) {
    need_folder(file.parent_path(), flag);
    return;
  }
  if (!std::filesystem::is_regular_file(status) && !std::filesystem::is_character_file(status)) {
    refuse_path(flag, file,
                std::filesystem::is_directory(status)
                    ? "is a folder: give a file"
                    : "is a link, a pipe or a device, which is not written to: give a file");
  }
  if (!may_write(file)) {
    refuse_path(flag, file, "cannot be written: check its permissions");
  }
}

}  // namespace stof::host

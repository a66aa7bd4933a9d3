#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "dataset/image.h"

// The common part of readers and writers of files.
namespace stof::dataset {

inline constexpr std::size_t kMaxPixels = std::size_t{1} << 26;

// "FILE: what is wrong: what to do", the one form of every message.
std::unexpected<Problem> refuse(std::string message);
std::unexpected<Problem> refuse(const std::filesystem::path& file, std::string_view what,
                                std::string_view remedy);

// PREFIX + ending.
std::filesystem::path file_of(const std::filesystem::path& prefix, const char* ending);

// The whole file. Refused: what is not a regular file, cannot be read, or has more than max_bytes.
Loaded<std::string> read_whole(const std::filesystem::path& file, std::size_t max_bytes);

// The file is what `bytes` are, whatever it was before: the one way to write a file by its name.
// Never a part of them: on a full disk it is as it was (posix::replace_named_file()). Refused: a
// link, also one that leads nowhere, and a pipe; a character device is written to.
std::expected<void, Problem> write_whole(const std::filesystem::path& file, std::string_view bytes);
// Why such a file cannot be written, by its errno.
std::unexpected<Problem> refuse_to_write(const std::filesystem::path& file, int error);

// Whether something has this name. A broken path counts as absent.
bool is_there(const std::filesystem::path& file);

// The fields of a Netpbm-like header: numbers separated by white space, # starts a comment.
// Empty when the bytes end or are not a decimal number of at most nine digits.
class HeaderCursor {
 public:
  explicit HeaderCursor(std::string_view bytes, std::size_t at) : bytes_(bytes), at_(at) {}
  std::optional<int> number();
  std::string_view word();  // up to the next white space; empty at the end
  // Steps over the single white space that separates header and pixels; false when it is not there.
  bool separator();
  std::size_t position() const { return at_; }

 private:
  void skip_blank();
  std::string_view bytes_;
  std::size_t at_;
};

inline std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace stof::dataset

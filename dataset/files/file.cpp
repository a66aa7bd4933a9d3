#include "dataset/files/file.h"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <span>

#include "posix/named_file.h"

namespace stof::dataset {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

}  // namespace

std::unexpected<Problem> refuse(std::string message) {
  return std::unexpected(Problem{std::move(message)});
}

std::unexpected<Problem> refuse(const std::filesystem::path& file, std::string_view what,
                                std::string_view remedy) {
  std::string message = file.string();
  message.append(": ").append(what).append(": ").append(remedy);
  return refuse(std::move(message));
}

std::filesystem::path file_of(const std::filesystem::path& prefix, const char* ending) {
  std::filesystem::path file = prefix;
  file += ending;
  return file;
}

Loaded<std::string> read_whole(const std::filesystem::path& file, std::size_t max_bytes) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    return refuse(file, "does not exist or cannot be reached", "check the path");
  }
  if (!std::filesystem::is_regular_file(status)) {
    return refuse(file, "is not a regular file", "give a file");
  }
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) {
    return refuse(file, "cannot be read", "check its permissions");
  }
  if (size > max_bytes) {
    return refuse(file, "has " + std::to_string(size) + " bytes, more than is possible here",
                  "check that it is the right file");
  }
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!stream || !stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    return refuse(file, "cannot be read", "check its permissions");
  }
  return bytes;
}

std::unexpected<Problem> refuse_to_write(const std::filesystem::path& file, int error) {
  switch (error) {
    case ELOOP:
      return refuse(file, "cannot be written: a link is not followed",
                    "give another name, or remove it");
    case ENXIO:
    case EISDIR:
      return refuse(file, "cannot be written: it is no regular file",
                    "give another name, or remove it");
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return refuse(file, "cannot be written: the disk is full", "make room, or give another disk");
    default:
      return refuse(file, std::string("cannot be written: ") + std::strerror(error),
                    "check the folder, its permissions and the free space");
  }
}

std::expected<void, Problem> write_whole(const std::filesystem::path& file,
                                         std::string_view bytes) {
  const int error = posix::replace_named_file(file.string(), std::as_bytes(std::span(bytes)));
  return error == 0 ? std::expected<void, Problem>() : refuse_to_write(file, error);
}

bool is_there(const std::filesystem::path& file) {
  std::error_code error;
  return std::filesystem::exists(file, error);
}

void HeaderCursor::skip_blank() {
  while (at_ < bytes_.size()) {
    if (bytes_[at_] == '#') {
      while (at_ < bytes_.size() && bytes_[at_] != '\n') {
        ++at_;
      }
    } else if (is_blank(bytes_[at_])) {
      ++at_;
    } else {
      return;
    }
  }
}

std::string_view HeaderCursor::word() {
  skip_blank();
  const std::size_t begin = at_;
  while (at_ < bytes_.size() && !is_blank(bytes_[at_]) && bytes_[at_] != '#') {
    ++at_;
  }
  return bytes_.substr(begin, at_ - begin);
}

std::optional<int> HeaderCursor::number() {
  const std::string_view digits = word();
  int value = 0;
  const std::from_chars_result result =
      std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (digits.empty() || digits.size() > 9 || digits.front() == '-' || result.ec != std::errc{} ||
      result.ptr != digits.data() + digits.size()) {
    return std::nullopt;
  }
  return value;
}

bool HeaderCursor::separator() {
  if (at_ >= bytes_.size() || !is_blank(bytes_[at_])) {
    return false;
  }
  ++at_;
  return true;
}

}  // namespace stof::dataset

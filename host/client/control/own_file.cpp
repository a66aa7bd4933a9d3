#include "host/client/control/own_file.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "posix/replaced_file.h"

namespace stof::client {
namespace {

constexpr mode_t kOwnFile = 0600;
constexpr mode_t kOwnFolder = 0700;
constexpr mode_t kOthers = 0077;
constexpr const char* kWritable = "make its folder one that you can write";
constexpr const char* kReadable = "make it a file that you can read";
constexpr std::string_view kNoFile =
    "neither XDG_CONFIG_HOME nor HOME is set: name a file with --keys";

std::unexpected<OpenError> refuse_errno(const std::string& file, const char* todo) {
  return refuse_file(Status::kDeviceError, file, std::string(std::strerror(errno)) + ": " + todo);
}

std::string folder_of(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string::npos || slash == 0 ? "" : file.substr(0, slash);
}

// With all folders above it.
void make_folder(const std::string& folder) {
  if (folder.empty() || ::access(folder.c_str(), F_OK) == 0) {
    return;
  }
  make_folder(folder_of(folder));
  static_cast<void>(::mkdir(folder.c_str(), kOwnFolder));
}

// Who else could put another file in its place; empty: nobody.
std::string_view who_replaces(const std::string& file) {
  struct stat folder{};
  const char* const nearest = file.starts_with('/') ? "/" : ".";
  const std::string name = folder_of(file);
  if (::stat(name.empty() ? nearest : name.c_str(), &folder) == 0 &&
      (folder.st_mode & S_IWOTH) != 0 && (folder.st_mode & S_ISVTX) == 0) {
    return "everybody may replace it: take the right to write its folder from the others (chmod "
           "o-w)";
  }
  return {};
}

// What is wrong with it; empty: nothing.
std::string problem_of(const struct stat& found, const std::string& file, std::string_view shared) {
  if (!S_ISREG(found.st_mode)) {
    return "no regular file: give one";
  }
  if ((found.st_mode & kOthers) != 0) {
    return std::string(shared);
  }
  if (found.st_uid != ::geteuid() && found.st_uid != 0 && ::geteuid() != 0) {
    return "it is another user's: pair for yourself";
  }
  return std::string(who_replaces(file));
}

}  // namespace

std::unexpected<OpenError> refuse_file(Status status, const std::string& file,
                                       std::string_view what) {
  return std::unexpected(OpenError{status, file + ": " + std::string(what)});
}

std::expected<posix::Fd, OpenError> lock_own_file(const std::string& file) {
  constexpr int kTries = 40;
  constexpr auto kPause = std::chrono::milliseconds(50);
  if (file.empty()) {
    return refuse_file(Status::kDeviceError, "keys", kNoFile);
  }
  make_folder(folder_of(file));
  posix::Fd lock(::open((file + ".lock").c_str(),
                        O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC,
                        kOwnFile));
  if (!lock.is_open()) {
    return refuse_errno(file + ".lock", kWritable);
  }
  for (int i = 0; ::flock(lock.get(), LOCK_EX | LOCK_NB) != 0; ++i) {
    if (errno != EWOULDBLOCK && errno != EINTR) {
      return refuse_errno(file + ".lock", kWritable);
    }
    if (i == kTries) {
      return refuse_file(Status::kTimeout, file, "another program changes it: end that first");
    }
    std::this_thread::sleep_for(kPause);
  }
  return lock;
}

std::expected<std::optional<std::vector<char>>, OpenError> read_own_file(const std::string& file,
                                                                         std::size_t most,
                                                                         std::string_view shared) {
  const posix::Fd in(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!in.is_open()) {
    if (errno == ENOENT || errno == ENOTDIR) {
      return std::nullopt;
    }
    return refuse_errno(file, kReadable);
  }
  struct stat found{};
  if (::fstat(in.get(), &found) != 0) {
    return refuse_errno(file, kReadable);
  }
  if (const std::string problem = problem_of(found, file, shared); !problem.empty()) {
    return refuse_file(Status::kDeviceError, file, problem);
  }
  std::vector<char> text(most + 1);
  std::size_t bytes = 0;
  while (bytes < text.size()) {
    const ssize_t got = ::read(in.get(), text.data() + bytes, text.size() - bytes);
    if (got == 0) {
      break;
    }
    if (got < 0 && errno != EINTR) {
      return refuse_errno(file, kReadable);
    }
    bytes += got < 0 ? 0 : static_cast<std::size_t>(got);
  }
  text.resize(bytes);
  return text;
}

std::expected<void, OpenError> write_own_file(const std::string& file, std::span<const char> text) {
  if (file.empty()) {
    return refuse_file(Status::kDeviceError, "keys", kNoFile);
  }
  make_folder(folder_of(file));
  const int error = posix::replace_file(file, std::as_bytes(text), kOwnFile);
  if (error != 0) {
    errno = error;
    return refuse_errno(file, kWritable);
  }
  return {};
}

}  // namespace stof::client

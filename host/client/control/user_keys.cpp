#include "host/client/control/user_keys.h"

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "firmware/wire/keys/key_text.h"
#include "posix/fd.h"
#include "posix/replaced_file.h"

namespace stof::client {
namespace {

constexpr mode_t kOwnFile = 0600;
constexpr mode_t kOwnFolder = 0700;
constexpr mode_t kOthers = 0077;
constexpr const char* kWritable = "make its folder one that you can write";
constexpr std::string_view kNoFile =
    "neither XDG_CONFIG_HOME nor HOME is set: name a file with --keys";

std::unexpected<OpenError> refuse(Status status, const std::string& file, std::string_view what) {
  return std::unexpected(OpenError{status, file + ": " + std::string(what)});
}

std::unexpected<OpenError> refuse_errno(const std::string& file, const char* todo) {
  return refuse(Status::kDeviceError, file, std::string(std::strerror(errno)) + ": " + todo);
}

const char* variable(const char* name) {
  const char* const value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): nobody sets one
  return value == nullptr ? "" : value;
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

// Open and locked; the lock goes with it.
std::expected<posix::Fd, OpenError> lock_file(const std::string& file) {
  constexpr int kTries = 200;
  constexpr auto kPause = std::chrono::milliseconds(50);
  if (file.empty()) {
    return refuse(Status::kDeviceError, "keys", kNoFile);
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
      return refuse(Status::kTimeout, file, "another program changes it: end that first");
    }
    std::this_thread::sleep_for(kPause);
  }
  return lock;
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

}  // namespace

std::string user_keys_file() {
  const std::string_view config = variable("XDG_CONFIG_HOME");
  if (!config.empty()) {
    return std::string(config) + "/stof/keys";
  }
  const std::string_view home = variable("HOME");
  return home.empty() ? "" : std::string(home) + "/.config/stof/keys";
}

std::expected<wire::KeyTable, OpenError> read_user_keys(const std::string& file) {
  constexpr const char* kReadable = "make it a file that you can read";
  const posix::Fd in(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!in.is_open()) {
    return errno == ENOENT || errno == ENOTDIR ? std::expected<wire::KeyTable, OpenError>()
                                               : refuse_errno(file, kReadable);
  }
  struct stat found{};
  if (::fstat(in.get(), &found) != 0) {
    return refuse_errno(file, kReadable);
  }
  if (!S_ISREG(found.st_mode)) {
    return refuse(Status::kDeviceError, file, "no regular file: give one");
  }
  if ((found.st_mode & kOthers) != 0) {
    return refuse(Status::kDeviceError, file,
                  "others may read these keys: chmod 600, and pair again if somebody did");
  }
  if (found.st_uid != ::geteuid() && found.st_uid != 0 && ::geteuid() != 0) {
    return refuse(Status::kDeviceError, file, "it is another user's: pair for yourself");
  }
  if (const std::string_view who = who_replaces(file); !who.empty()) {
    return refuse(Status::kDeviceError, file, who);
  }
  std::vector<char> text(wire::kMostKeyText + 1);
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
  wire::KeyTable keys;
  const Status read = wire::read_keys({text.data(), bytes}, keys);
  wire::wipe(std::as_writable_bytes(std::span(text)));
  if (read != Status::kOk) {
    return refuse(Status::kCorrupt, file,
                  read == Status::kUnsupported ? "of a later version: update this program"
                                               : "no key file, or damaged: move it away and pair "
                                                 "again");
  }
  return keys;
}

std::expected<void, OpenError> write_user_keys(const std::string& file,
                                               const wire::KeyTable& keys) {
  if (file.empty()) {
    return refuse(Status::kDeviceError, "keys", kNoFile);
  }
  make_folder(folder_of(file));
  std::vector<char> space(wire::kMostKeyText);
  const int error = posix::replace_file(
      file, std::as_bytes(std::span<const char>(wire::write_keys(keys, space))), kOwnFile);
  wire::wipe(std::as_writable_bytes(std::span(space)));
  if (error != 0) {
    errno = error;
    return refuse_errno(file, kWritable);
  }
  return {};
}

std::expected<void, OpenError> update_user_keys(const std::string& file, const ChangeKeys& change) {
  const std::expected<posix::Fd, OpenError> lock = lock_file(file);
  if (!lock) {
    return std::unexpected(lock.error());
  }
  const std::expected<wire::KeyTable, OpenError> keys = read_user_keys(file);
  if (!keys) {
    return std::unexpected(keys.error());
  }
  const std::expected<wire::KeyTable, OpenError> next = change(*keys);
  return next ? write_user_keys(file, *next) : std::unexpected(next.error());
}

std::expected<void, OpenError> add_user_key(const std::string& file, const wire::Key& key) {
  return update_user_keys(
      file, [&](const wire::KeyTable& keys) -> std::expected<wire::KeyTable, OpenError> {
        wire::KeyTable next;
        for (const wire::Key& old : keys.all()) {
          if (old.id != key.id || old.device != key.device) {
            static_cast<void>(next.add(old));
          }
        }
        if (const Status added = next.add(key); added != Status::kOk) {
          return refuse(added, file,
                        added == Status::kTooLarge
                            ? "holds as many keys as it takes: stof unpair ends one, with --forget "
                              "those of a sensor that is gone"
                            : "has another sensor's key of that number: pair again");
        }
        return next;
      });
}

}  // namespace stof::client

#include "tests/support/disk_states.h"

#include <algorithm>
#include <cstdarg>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

#include <fcntl.h>
#include <sys/types.h>

namespace stof::test {
namespace {

DiskRecording* running = nullptr;

}  // namespace

// Names and the bytes of inodes, flushed and as they would be.
struct DiskRecording::State {
  std::map<std::string, int> names;
  std::map<int, std::string> bytes;
};

DiskRecording::DiskRecording(std::filesystem::path folder) : folder_(std::move(folder)) {
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    std::ifstream file(entry.path(), std::ios::binary);
    begin_[entry.path().filename().string()] = {std::istreambuf_iterator<char>(file), {}};
  }
  running = this;
}

DiskRecording::~DiskRecording() { stop(); }

void DiskRecording::stop() {
  if (running == this) {
    running = nullptr;
  }
}

bool DiskRecording::ours(const std::string& name) const {
  return std::filesystem::path(name).parent_path() == folder_;
}

void DiskRecording::note_open(const std::string& name, int fd, bool creates) {
  folders_[fd] = std::filesystem::path(name) == folder_;
  inodes_.erase(fd);
  if (creates && ours(name)) {
    inodes_[fd] = next_inode_;
    calls_.push_back({.what = What::kCreate,
                      .file = next_inode_++,
                      .name = std::filesystem::path(name).filename().string()});
  }
}

void DiskRecording::note_write(int fd, const void* bytes, std::size_t count) {
  const auto file = inodes_.find(fd);
  if (file != inodes_.end()) {
    calls_.push_back({.what = What::kWrite,
                      .file = file->second,
                      .bytes = {static_cast<const char*>(bytes), count}});
  }
}

void DiskRecording::note_flush(int fd) {
  if (flushes_nothing) {
    return;
  }
  if (const auto file = inodes_.find(fd); file != inodes_.end()) {
    calls_.push_back({.what = What::kFlushFile, .file = file->second});
  } else if (folders_[fd]) {
    calls_.push_back({.what = What::kFlushFolder});
  }
}

void DiskRecording::note_rename(const std::string& from, const std::string& to) {
  if (ours(from)) {
    calls_.push_back({.what = What::kRename,
                      .name = std::filesystem::path(from).filename().string(),
                      .to = std::filesystem::path(to).filename().string()});
  }
}

void DiskRecording::note_unlink(const std::string& name) {
  if (ours(name)) {
    calls_.push_back(
        {.what = What::kUnlink, .name = std::filesystem::path(name).filename().string()});
  }
}

// choose(): whether the next thing that may be there or not is there.
template <typename Choose>
DiskRecording::State DiskRecording::replay(std::size_t cut, Choose&& choose) const {
  State state;
  int old = -1;  // inodes of before
  for (const auto& [name, bytes] : begin_) {
    state.names[name] = old;
    state.bytes[old--] = bytes;
  }
  const auto flushed_later = [&](std::size_t at, auto fits) {
    return std::any_of(calls_.begin() + static_cast<std::ptrdiff_t>(at),
                       calls_.begin() + static_cast<std::ptrdiff_t>(cut), fits);
  };
  const auto in_folder = [&](std::size_t at) {
    return flushed_later(at, [](const Call& call) { return call.what == What::kFlushFolder; }) ||
           choose();
  };
  std::map<int, std::size_t> sizes;  // of files as they were written
  for (std::size_t at = 0; at < cut; ++at) {
    const Call& call = calls_[at];
    if (call.what == What::kCreate) {
      if (in_folder(at)) {
        state.names[call.name] = call.file;
      }
      state.bytes[call.file];
    } else if (call.what == What::kWrite) {
      const bool flushed = flushed_later(at, [&](const Call& later) {
        return later.what == What::kFlushFile && later.file == call.file;
      });
      std::string& bytes = state.bytes[call.file];
      std::size_t& begin = sizes[call.file];
      for (std::size_t from = 0; from < call.bytes.size(); from += kSector) {
        if (flushed || choose()) {
          const std::string sector = call.bytes.substr(from, kSector);
          bytes.resize(std::max(bytes.size(), begin + from + sector.size()));
          bytes.replace(begin + from, sector.size(), sector);
        }
      }
      begin += call.bytes.size();
    } else if (call.what == What::kRename && in_folder(at) && state.names.contains(call.name)) {
      state.names[call.to] = state.names[call.name];
      state.names.erase(call.name);
    } else if (call.what == What::kUnlink && in_folder(at)) {
      state.names.erase(call.name);
    }
  }
  return state;
}

std::size_t DiskRecording::open_things(std::size_t cut) const {
  std::size_t things = 0;
  static_cast<void>(replay(cut, [&] { return ++things > 0; }));
  return things;
}

void DiskRecording::write_state(std::size_t cut, std::uint64_t choice, Random& random,
                                const std::filesystem::path& to) const {
  std::size_t thing = 0;
  const State state = replay(cut, [&] {
    const std::size_t bit = thing++;
    return bit < 64 ? (choice >> bit & 1U) != 0 : random.between(0, 1) != 0;
  });
  for (const auto& entry : std::filesystem::directory_iterator(to)) {
    std::filesystem::remove_all(entry.path());
  }
  for (const auto& [name, inode] : state.names) {
    std::ofstream(to / name, std::ios::binary) << state.bytes.at(inode);
  }
}

DiskFolders::DiskFolders() {
  std::string name = (std::filesystem::temp_directory_path() / "stof_disk_XXXXXX").string();
  root_ = mkdtemp(name.data());
  std::filesystem::create_directories(live());
  std::filesystem::create_directories(after());
}

DiskFolders::~DiskFolders() { std::filesystem::remove_all(root_); }

void each_state_after_a_cut(const DiskRecording& disk, const std::filesystem::path& after,
                            const std::function<void()>& visit) {
  constexpr std::size_t kMostThings = 8;
  constexpr std::uint64_t kMostChoices = 512;
  Random random(3);
  for (std::size_t cut = 0; cut <= disk.calls(); ++cut) {
    const std::size_t things = disk.open_things(cut);
    const bool all = things <= kMostThings;
    const std::uint64_t choices = all ? std::uint64_t{1} << things : kMostChoices;
    for (std::uint64_t k = 0; k < choices; ++k) {
      disk.write_state(cut, all ? k : random.next(), random, after);
      visit();
    }
  }
}

}  // namespace stof::test

using stof::test::running;

extern "C" {
int __real_open(const char* name, int flags, ...);
ssize_t __real_write(int fd, const void* bytes, size_t count);
int __real_rename(const char* from, const char* to);
int __real_unlink(const char* name);

int __wrap_open(const char* name, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  const int fd = __real_open(name, flags, mode);
  if (fd >= 0 && running != nullptr) {
    running->note_open(name, fd, (flags & O_CREAT) != 0);
  }
  return fd;
}

ssize_t __wrap_write(int fd, const void* bytes, size_t count) {
  const ssize_t written = __real_write(fd, bytes, count);
  if (written > 0 && running != nullptr) {
    running->note_write(fd, bytes, static_cast<std::size_t>(written));
  }
  return written;
}

// The medium itself, which may take long, is not asked.
int __wrap_fsync(int fd) {
  if (running != nullptr) {
    running->note_flush(fd);
  }
  return 0;
}

int __wrap_rename(const char* from, const char* to) {
  const int result = __real_rename(from, to);
  if (result == 0 && running != nullptr) {
    running->note_rename(from, to);
  }
  return result;
}

int __wrap_unlink(const char* name) {
  const int result = __real_unlink(name);
  if (result == 0 && running != nullptr) {
    running->note_unlink(name);
  }
  return result;
}
}

#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/support/random.h"

// What a disk may hold after its power went. The linker leads open, write, fsync, rename and unlink
// here: LINKER:--wrap=open,--wrap=write,--wrap=fsync,--wrap=rename,--wrap=unlink. While a recording
// runs, what is done below its folder is written down, and done.
//
// Of a power cut between any two calls: what was written to a file and not flushed is there in any
// subset of its sectors, at any length that these need; what was created, renamed or unlinked and
// not flushed with the folder has happened or not, each by itself.
namespace stof::test {

class DiskRecording {
 public:
  // The folder's files as they are now are flushed.
  explicit DiskRecording(std::filesystem::path folder);
  ~DiskRecording();
  DiskRecording(const DiskRecording&) = delete;
  DiskRecording& operator=(const DiskRecording&) = delete;

  void stop();
  std::size_t calls() const noexcept { return calls_.size(); }
  // Things of which the cut before call `cut` may have left each or not.
  std::size_t open_things(std::size_t cut) const;
  // Writes one of these states into an empty folder. choice: bit k: thing k is there; beyond 64
  // things the random numbers decide.
  void write_state(std::size_t cut, std::uint64_t choice, Random& random,
                   const std::filesystem::path& to) const;

  // Called by the wrapped calls.
  void note_open(const std::string& name, int fd, bool creates);
  void note_write(int fd, const void* bytes, std::size_t count);
  void note_flush(int fd);
  void note_rename(const std::string& from, const std::string& to);
  void note_unlink(const std::string& name);
  // A disk that says it has flushed and has not: what this is good for must notice.
  bool flushes_nothing = false;

 private:
  static constexpr std::size_t kSector = 512;

  enum class What { kCreate, kWrite, kFlushFile, kFlushFolder, kRename, kUnlink };
  struct Call {
    What what;
    int file = -1;  // an inode
    std::string name{};
    std::string to{};
    std::string bytes{};
  };
  struct State;

  bool ours(const std::string& name) const;
  template <typename Choose>
  State replay(std::size_t cut, Choose&& choose) const;

  std::filesystem::path folder_;
  std::map<std::string, std::string> begin_;  // names and bytes
  std::vector<Call> calls_;
  std::map<int, int> inodes_;    // of open files, by descriptor
  std::map<int, bool> folders_;  // open folders, by descriptor
  int next_inode_ = 0;
};

// Two folders of their own, empty at first and gone with this.
class DiskFolders {
 public:
  DiskFolders();
  ~DiskFolders();
  DiskFolders(const DiskFolders&) = delete;
  DiskFolders& operator=(const DiskFolders&) = delete;
  std::filesystem::path live() const { return root_ / "live"; }    // of the recording
  std::filesystem::path after() const { return root_ / "after"; }  // for its states

 private:
  std::filesystem::path root_;
};

// Calls visit() with each state in `after` that a cut at any call of the recording may have left;
// of a cut after which more than eight things are open, 512 states at random.
void each_state_after_a_cut(const DiskRecording& disk, const std::filesystem::path& after,
                            const std::function<void()>& visit);

}  // namespace stof::test

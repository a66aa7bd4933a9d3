#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <span>
#include <string>

#include "dataset/image.h"
#include "host/recording/mcap/bytes.h"
#include "posix/fd.h"

// Where a recording's bytes go to and come from.
namespace stof::mcap {

using dataset::Problem;

// What `next` returns, where all went well so far.
template <typename Next>
std::expected<void, Problem> then(const std::expected<void, Problem>& done, const Next& next) {
  return done ? next() : done;
}

// Bytes at the end of a file. For one thread.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  // All of them, or a problem; then some may be there.
  virtual std::expected<void, Problem> write(Bytes bytes) = 0;
  // Returns when a power cut cannot take what was written.
  virtual std::expected<void, Problem> sync() = 0;
  // The file ends here from now on; no further back than its begin.
  virtual std::expected<void, Problem> cut_to(std::uint64_t size) = 0;
};

// Bytes at any place of a file that does not change.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  // Fills `to`; false: they are not there, or the device failed.
  virtual bool read(std::uint64_t offset, std::span<std::byte> to) const = 0;
};

// "FILE: what is wrong: what to do" in every problem.
class FileSink : public ByteSink {
 public:
  enum class Existing : std::uint8_t {
    kRefuse,   // there must be no file of the name
    kReplace,  // what it had is gone
    kAppend,   // goes on behind what it has; who asks for it holds FileSource::lock()
  };
  // Refuses what is not a regular file (devices, pipes, folders, links). Nobody else may write it
  // meanwhile: a second sink of the same file is refused, in any program.
  static std::expected<FileSink, Problem> open(const std::filesystem::path& file,
                                               Existing existing);
  std::expected<void, Problem> write(Bytes bytes) override;
  std::expected<void, Problem> sync() override;
  std::expected<void, Problem> cut_to(std::uint64_t size) override;

 private:
  FileSink(std::filesystem::path file, posix::Fd&& fd)
      : file_(std::move(file)), fd_(std::move(fd)) {}
  std::unexpected<Problem> problem(int error) const;

  std::filesystem::path file_;
  posix::Fd fd_;
};

class FileSource : public ByteSource {
 public:
  // Regular files only.
  static std::expected<FileSource, Problem> open(const std::filesystem::path& file);
  // Refuses where a FileSink writes the file; keeps others from it while this lives.
  std::expected<void, Problem> lock(const std::filesystem::path& file);
  // Whether a FileSink writes it, or a lock() is held, now. Whoever wants one in this very moment
  // may be refused.
  bool is_locked() const;
  std::uint64_t size() const override { return size_; }
  bool read(std::uint64_t offset, std::span<std::byte> to) const override;

 private:
  FileSource(posix::Fd&& fd, std::uint64_t size) : fd_(std::move(fd)), size_(size) {}
  posix::Fd fd_;
  std::uint64_t size_;
};

// Borrowed bytes.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(Bytes bytes) : bytes_(bytes) {}
  std::uint64_t size() const override { return bytes_.size(); }
  bool read(std::uint64_t offset, std::span<std::byte> to) const override;

 private:
  Bytes bytes_;
};

}  // namespace stof::mcap

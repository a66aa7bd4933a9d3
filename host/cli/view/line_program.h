#pragma once

#include <expected>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "posix/fd.h"

namespace stof::host {

// A program that runs beside this one and prints lines. For one thread but for interrupt(); ended
// (SIGKILL) and waited for where it still runs when this goes.
class LineProgram {
 public:
  // words: the program, by its path, and its arguments. It gets no other file of this process than
  // these two streams, and no input. One line: why not.
  static std::expected<LineProgram, std::string> start(const std::vector<std::string>& words);
  LineProgram(LineProgram&& other) noexcept;
  LineProgram& operator=(LineProgram&&) = delete;
  LineProgram(const LineProgram&) = delete;
  LineProgram& operator=(const LineProgram&) = delete;
  ~LineProgram();

  static constexpr std::size_t kMostLine = std::size_t{1} << 24;  // bytes; what is longer is cut
  // The next line of its stdout, without its end; none: it has closed that and stderr.
  std::optional<std::string> next_line();
  // SIGINT: it ends as a user would end it. Before wait() has returned; for any thread.
  void interrupt() const noexcept;
  // Until it has ended, soon after next_line() had none: its exit code, 128 and more where a signal
  // ended it.
  int wait();
  // The last line that it wrote to stderr so far, at most 1,000 bytes.
  const std::string& complaint() const noexcept { return complaint_; }

 private:
  LineProgram(pid_t child, posix::Fd out, posix::Fd complaints) noexcept;
  // False: both streams have ended.
  bool read_some();
  void take_complaint(const char* bytes, std::size_t size);

  pid_t child_;  // -1: none that has to be waited for
  posix::Fd out_;
  posix::Fd complaints_;
  std::string read_;  // of stdout, and no line yet
  std::string complaint_;
  bool complaint_ended_ = false;
};

}  // namespace stof::host

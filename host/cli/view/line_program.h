#pragma once

#include <chrono>
#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "posix/fd.h"

namespace stof::host {

// A program that runs beside this one and prints lines. For one thread; ended (SIGKILL) and waited
// for where it still runs when this goes.
class LineProgram {
 public:
  // Whether it goes on: asked five times a second while its lines are awaited. Once it does not, it
  // is ended as a user ends it (SIGINT), and kPatience later by SIGKILL.
  using GoesOn = std::function<bool()>;
  static constexpr std::chrono::seconds kPatience{20};
  // words: the program, by its path, and its arguments. It gets no other file of this process than
  // these two streams, and no input. One line: why not.
  static std::expected<LineProgram, std::string> start(const std::vector<std::string>& words,
                                                       GoesOn goes_on);
  LineProgram(LineProgram&& other) noexcept;
  LineProgram& operator=(LineProgram&&) = delete;
  LineProgram(const LineProgram&) = delete;
  LineProgram& operator=(const LineProgram&) = delete;
  ~LineProgram();

  static constexpr std::size_t kMostLine = std::size_t{1} << 24;  // bytes; what is longer is cut
  // The next line of its stdout, without its end; none: it has closed that and stderr.
  std::optional<std::string> next_line();
  // Until it has ended, soon after next_line() had none: its exit code, 128 and more where a signal
  // ended it.
  int wait();
  // The last line that it wrote to stderr so far, at most 1,000 bytes.
  const std::string& complaint() const noexcept { return complaint_; }

 private:
  using Clock = std::chrono::steady_clock;

  LineProgram(pid_t child, posix::Fd out, posix::Fd complaints, GoesOn goes_on) noexcept;
  // False: both streams have ended.
  bool read_some();
  void take_complaint(const char* bytes, std::size_t size);
  void look_whether_it_goes_on();

  pid_t child_;  // -1: none that has to be waited for
  posix::Fd out_;
  posix::Fd complaints_;
  std::string read_;  // of stdout, and no line yet
  std::string complaint_;
  bool complaint_ended_ = false;
  GoesOn goes_on_;
  std::optional<Clock::time_point> killed_at_;  // none: it was not interrupted
};

}  // namespace stof::host

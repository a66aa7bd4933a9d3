#include "host/cli/progress_line.h"

#include <array>
#include <chrono>
#include <string>
#include <utility>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "posix/fd.h"
#include "tests/support/pty.h"

namespace stof::host {
namespace {

using namespace std::chrono_literals;

// Takes stderr for itself.
class ErrorsTo {
 public:
  explicit ErrorsTo(int fd) : before_(::dup(STDERR_FILENO)) { ::dup2(fd, STDERR_FILENO); }
  ~ErrorsTo() {
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  ErrorsTo(const ErrorsTo&) = delete;
  ErrorsTo& operator=(const ErrorsTo&) = delete;

 private:
  int before_;
};

// What work() leaves on a terminal, which makes two bytes of the end of a line.
template <typename Work>
std::string on_terminal(Work&& work) {
  test::Pty far;
  EXPECT_TRUE(far.open());
  const posix::Fd terminal(::open(far.name().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  EXPECT_TRUE(terminal.is_open());
  {
    const ErrorsTo errors(terminal.get());
    std::forward<Work>(work)();
  }
  EXPECT_EQ(::write(terminal.get(), "$", 1), 1);  // the end
  std::string shown;
  while (!shown.ends_with('$')) {
    const std::string next = far.read(1);
    if (next.empty()) {
      ADD_FAILURE() << "nothing came";
      break;
    }
    shown += next;
  }
  return shown;
}

TEST(TerminalLine, OverwritesItselfAndEnds) {
  EXPECT_EQ(on_terminal([] {
              TerminalLine line(false);
              line.show("abcdef");
              line.show("xy");
              line.end();
              line.end();
            }),
            "\rabcdef\rxy    \r\n$");
}

TEST(TerminalLine, IsTakenAwayWhereSomethingElseIsPrinted) {
  EXPECT_EQ(on_terminal([] {
              TerminalLine line(false);
              line.show("abc");
              line.clear();
            }),
            "\rabc\r   \r$");
}

TEST(TerminalLine, SaysNothingBesideJson) {
  EXPECT_EQ(on_terminal([] {
              TerminalLine line(true);
              EXPECT_FALSE(line.due());
              line.show("abc");
              line.clear();
            }),
            "$");
}

TEST(TerminalLine, SaysNothingWhereThereIsNoTerminal) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  {
    const ErrorsTo errors(ends[1]);
    TerminalLine line(false);
    EXPECT_FALSE(line.due());
    line.show("abc");
  }
  ::close(ends[1]);
  std::array<char, 16> part{};
  EXPECT_EQ(::read(ends[0], part.data(), part.size()), 0);
  ::close(ends[0]);
}

TEST(TerminalLine, IsDueNotBeforeItsTimeNorTwiceAtOnce) {
  static_cast<void>(on_terminal([] {
    TerminalLine later(false, 1h);
    EXPECT_FALSE(later.due());
    TerminalLine now(false);
    EXPECT_TRUE(now.due());
  }));
}

TEST(ExportProgress, TellsFramesAndHowFarItIs) {
  EXPECT_EQ(on_terminal([] { ExportProgress("a.mcap", false, 0ms).show(12, 50, 200); }),
            "\rexporting a.mcap: 12 frames, 25 %\r\n$");
  EXPECT_EQ(on_terminal([] { ExportProgress("front", false, 0ms).show(12, 48); }),
            "\rexporting front: 12 of 48 frames, 25 %\r\n$");
  EXPECT_EQ(on_terminal([] { ExportProgress("front", false, 0ms).show(12, 0); }),
            "\rexporting front: 12 frames\r\n$");
  EXPECT_EQ(on_terminal([] { ExportProgress("front", true, 0ms).show(12, 48); }), "$");
}

}  // namespace
}  // namespace stof::host

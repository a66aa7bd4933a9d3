#include "host/cli/progress_line.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <unistd.h>

#include "host/client/printable.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::chrono::milliseconds kBetween{500};
constexpr std::uint64_t kWhole = 100;

unsigned long long percent(std::uint64_t part, std::uint64_t total) {
  return total == 0 ? kWhole : std::min(part * kWhole / total, kWhole);
}

}  // namespace

TerminalLine::TerminalLine(bool json, std::chrono::milliseconds first)
    : shown_(!json && ::isatty(STDERR_FILENO) == 1), due_(Clock::now() + first) {}

bool TerminalLine::due() {
  const Clock::time_point now = Clock::now();
  if (!shown_ || now < due_) {
    return false;
  }
  due_ = now + kBetween;
  return true;
}

void TerminalLine::show(const std::string& text) {
  if (!shown_) {
    return;
  }
  // What was longer is written over.
  const std::string rest(width_ > text.size() ? width_ - text.size() : 0, ' ');
  std::fprintf(stderr, "\r%s%s", text.c_str(), rest.c_str());
  std::fflush(stderr);
  width_ = text.size();
}

void TerminalLine::end() {
  if (std::exchange(width_, 0) != 0) {
    std::fputc('\n', stderr);
  }
}

void TerminalLine::clear() {
  if (const std::size_t width = std::exchange(width_, 0); width != 0) {
    std::fprintf(stderr, "\r%s\r", std::string(width, ' ').c_str());
    std::fflush(stderr);
  }
}

void ProgressLine::show(std::size_t bytes, std::size_t total) {
  constexpr std::size_t kWidth = 40;
  const std::size_t done = total == 0 ? kWidth : std::min(bytes * kWidth / total, kWidth);
  line_.show(printed("[%s%s] %zu of %zu bytes (%llu %%)", std::string(done, '#').c_str(),
                     std::string(kWidth - done, ' ').c_str(), bytes, total, percent(bytes, total)));
}

ExportProgress::ExportProgress(const std::string& what, bool json, std::chrono::milliseconds first)
    : what_(client::printable(what)), line_(json, first) {}

void ExportProgress::show(std::uint64_t frames, std::uint64_t bytes, std::uint64_t total) {
  if (line_.due()) {
    line_.show(printed("exporting %s: %llu frames, %llu %%", what_.c_str(),
                       static_cast<unsigned long long>(frames), percent(bytes, total)));
  }
}

void ExportProgress::show(std::uint64_t frames, std::uint64_t wanted) {
  if (line_.due()) {
    const auto count = static_cast<unsigned long long>(frames);
    line_.show(wanted == 0
                   ? printed("exporting %s: %llu frames", what_.c_str(), count)
                   : printed("exporting %s: %llu of %llu frames, %llu %%", what_.c_str(), count,
                             static_cast<unsigned long long>(wanted), percent(frames, wanted)));
  }
}

}  // namespace stof::host

#include "host/cli/recording/reading_progress.h"

#include <cstdio>
#include <utility>

#include <unistd.h>

#include "host/client/printable.h"

namespace stof::host {
namespace {

constexpr std::chrono::seconds kBeforeFirst{2};
constexpr std::chrono::milliseconds kBetween{500};

}  // namespace

ReadingProgress::ReadingProgress(std::string file)
    : file_(client::printable(file)),
      due_(Clock::now() + kBeforeFirst),
      terminal_(::isatty(STDERR_FILENO) == 1) {}

ReadingProgress::~ReadingProgress() {
  if (open_) {
    std::fputc('\n', stderr);
  }
}

void ReadingProgress::show(std::uint64_t bytes, std::uint64_t total) {
  if (!terminal_ || Clock::now() < due_) {
    return;
  }
  due_ = Clock::now() + kBetween;
  open_ = true;
  std::fprintf(stderr, "\rreading %s: %llu %%", file_.c_str(),
               static_cast<unsigned long long>(total == 0 ? 100 : bytes * 100 / total));
  std::fflush(stderr);
}

mcap::Progress ReadingProgress::callback() {
  return [this](std::uint64_t bytes, std::uint64_t total) { show(bytes, total); };
}

}  // namespace stof::host

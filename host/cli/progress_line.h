#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <utility>

#include <unistd.h>

namespace stof::host {

// A bar on stderr that is overwritten, where that is a terminal; nothing elsewhere.
class ProgressLine {
 public:
  void show(std::size_t bytes, std::size_t total) {
    if (!shown_) {
      return;
    }
    std::array<char, kWidth + 1> bar{};
    const std::size_t done = total == 0 ? kWidth : bytes * kWidth / total;
    for (std::size_t i = 0; i < kWidth; ++i) {
      bar[i] = i < done ? '#' : ' ';
    }
    std::fprintf(stderr, "\r[%s] %zu of %zu bytes (%zu %%)", bar.data(), bytes, total,
                 total == 0 ? 100 : bytes * 100 / total);
    std::fflush(stderr);
    open_ = true;
  }
  void end() {
    if (std::exchange(open_, false)) {
      std::fputc('\n', stderr);
    }
  }

 private:
  static constexpr std::size_t kWidth = 40;
  bool shown_ = ::isatty(STDERR_FILENO) == 1;
  bool open_ = false;
};

}  // namespace stof::host

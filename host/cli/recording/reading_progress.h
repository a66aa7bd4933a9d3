#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "host/recording/mcap/progress.h"

namespace stof::host {

// A line on stderr that is overwritten, on a terminal alone, where a file takes longer than two
// seconds to read.
class ReadingProgress {
 public:
  explicit ReadingProgress(std::string file);
  ~ReadingProgress();  // ends the line
  ReadingProgress(const ReadingProgress&) = delete;
  ReadingProgress& operator=(const ReadingProgress&) = delete;

  void show(std::uint64_t bytes, std::uint64_t total);
  // For what takes one; this outlives it.
  mcap::Progress callback();

 private:
  using Clock = std::chrono::steady_clock;
  std::string file_;
  Clock::time_point due_;
  bool terminal_;
  bool open_ = false;
};

}  // namespace stof::host

#pragma once

#include <cstdint>
#include <string>

#include "host/cli/progress_line.h"
#include "host/recording/mcap/progress.h"

namespace stof::host {

// How far a file is read, where that takes longer than two seconds.
class ReadingProgress {
 public:
  ReadingProgress(const std::string& file, bool json);

  void show(std::uint64_t bytes, std::uint64_t total);
  // For what takes one; this outlives it.
  mcap::Progress callback();

 private:
  std::string file_;
  TerminalLine line_;
};

}  // namespace stof::host

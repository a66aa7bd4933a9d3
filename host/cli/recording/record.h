#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/cli/receive.h"

namespace stof::host {

struct RecordOptions : ReceiveOptions {
  std::filesystem::path file;
  std::uint64_t frames = 0;  // 0: no limit
  double seconds = 0;        // from the first frame; 0: no limit
  bool raw = false;          // what the cameras gave, too
  bool force = false;        // replaces a file that is there
  bool json = false;
  std::string program;  // name and version, for the file
};

// Adds `stof record` and its flags; it runs when the command line was parsed.
void add_record(CLI::App& app, RecordOptions& options, const char* program);

// `stof record`: receives and writes a recording. Throws Failure.
void record(const RecordOptions& options);

}  // namespace stof::host

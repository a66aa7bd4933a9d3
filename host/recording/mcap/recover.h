#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>

#include "host/recording/mcap/progress.h"
#include "host/recording/mcap/reader.h"

namespace stof::mcap {

struct Recovered {
  bool was_whole = false;           // nothing was to be done
  std::uint64_t messages = 0;       // in the file that is whole now
  std::uint64_t cut_bytes = 0;      // behind the last whole record, given up
  std::uint64_t damaged = 0;        // records that could not be read, given up
  std::uint64_t damaged_bytes = 0;  // of them, and between records
  std::uint32_t files = 1;  // that lay one behind the other; a copy does not say where they met
};

// Gives a cut file its index again, in place: what lies behind its last whole record is cut off, no
// other byte changes. Refused, and left as it is, is a file in which anything sound follows damage,
// or whose index names what is not there, or that another program writes.
std::expected<Recovered, Problem> recover(const std::filesystem::path& file,
                                          const Progress& progress = {});

// Writes what can be read of `file` as a whole file: all messages, attachments and metadata of
// records that are sound. `out` must not exist, or is replaced; it is never `file`.
std::expected<Recovered, Problem> recover(const std::filesystem::path& file,
                                          const std::filesystem::path& out,
                                          FileSink::Existing existing = FileSink::Existing::kRefuse,
                                          const Progress& progress = {});

}  // namespace stof::mcap

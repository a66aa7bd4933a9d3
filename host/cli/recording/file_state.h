#pragma once

#include <cstdint>
#include <string>

#include "host/recording/recording.h"

namespace stof::host {

// "cut: stof recover FILE": whether a recording is whole, and what to do. damaged: records.
const char* file_state_text(const recording::FileState& state, std::uint64_t damaged);

// Of a whole recording nothing has to be told.
inline bool is_whole(const recording::FileState& state) {
  return state.end == mcap::StreamReader::End::kWhole && state.indexed;
}

// "2 recordings lie in it, one behind the other"; nothing is measured from one to the next.
std::string files_text(const recording::FileState& state);

}  // namespace stof::host

#include "host/cli/recording/file_state.h"

namespace stof::host {

const char* file_state_text(const recording::FileState& state, std::uint64_t damaged) {
  using End = mcap::StreamReader::End;
  if (damaged != 0) {
    return "damaged: stof recover FILE OUT writes what is sound";
  }
  if (state.end != End::kWhole && state.being_written) {
    return "not whole yet: another program writes it";
  }
  switch (state.end) {
    case End::kWhole:
      return state.indexed ? "whole, with index"
                           : "ends, but its index is damaged: stof recover FILE";
    case End::kDamaged:
      return "damaged at its end: stof recover FILE";
    default:
      return "cut: stof recover FILE";
  }
}

std::string files_text(const recording::FileState& state) {
  return std::to_string(state.files) + " recordings lie in it, one behind the other";
}

}  // namespace stof::host

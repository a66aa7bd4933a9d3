#pragma once

#include <cstdint>

#include "host/recording/mcap/records.h"

namespace stof::mcap {

// One record of a file: where it begins, and its content.
struct RecordAt {
  Opcode opcode = Opcode::kHeader;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;  // of the whole record
  Bytes content{};           // borrowed
};

}  // namespace stof::mcap

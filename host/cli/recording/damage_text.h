#pragma once

#include <cstdint>
#include <string>

#include "host/text/printed.h"

namespace stof::host {

// "2 records in it are damaged, 4096 bytes", the reason for which info, export and recover end
// with 1.
inline std::string damage_text(std::uint64_t records, std::uint64_t bytes) {
  return printed("%llu %s damaged, %llu bytes", static_cast<unsigned long long>(records),
                 records == 1 ? "record in it is" : "records in it are",
                 static_cast<unsigned long long>(bytes));
}

}  // namespace stof::host

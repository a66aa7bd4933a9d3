#pragma once

#include <cstdint>
#include <functional>

namespace stof::mcap {

// Told often, from the thread that reads: bytes of the file that were read, of all. Empty: nobody
// asks.
using Progress = std::function<void(std::uint64_t bytes, std::uint64_t total)>;

}  // namespace stof::mcap

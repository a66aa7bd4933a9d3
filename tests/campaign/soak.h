#pragma once

#include <cstdint>

namespace stof::campaign {

// So many hours of emulated time at 160x120 and 64x16, with a fault at random every few seconds, of
// any kind that can begin at any time. Prints a JSON object a minute of faults and one at the end.
// True: no false frame, memory constant, counters true.
bool soak(double hours, std::uint64_t seed);

}  // namespace stof::campaign

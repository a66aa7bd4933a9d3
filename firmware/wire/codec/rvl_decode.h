#pragma once

#include <cstddef>
#include <span>

#include "dsp/base/status.h"

namespace stof::wire {

// From the code of rvl_encode.h.
// Any bytes; reads and writes nothing outside of both spans. kCorrupt: not the code of exactly
// values.size() values: too short, too long, runs longer than that, an empty run of other values
// before the last one, a number of more than 6 nibbles, something else than 0 after the end. The
// content of `values` is undefined then. Differences wrap modulo 2^16 or 2^8. Codes that
// rvl_encode() would not write are legal: longer numbers than needed, runs of other values in
// several parts, a difference that leads to 0.
template <typename T>
Status rvl_decode(std::span<const std::byte> in, std::span<T> values) noexcept;

}  // namespace stof::wire

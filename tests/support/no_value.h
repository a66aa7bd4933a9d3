#pragma once

#include <limits>

namespace stof::test {

// What a map of disparity or depth holds where it has no value.
inline constexpr float kNone = std::numeric_limits<float>::infinity();

}  // namespace stof::test

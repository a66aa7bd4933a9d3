#pragma once

#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace stof::test {

// How often a random test runs: `few`, or `many` where the environment says STOF_LONG=1.
inline std::uint64_t runs(std::uint64_t few, std::uint64_t many) noexcept {
  const char* const value = std::getenv("STOF_LONG");
  return value != nullptr && std::string_view(value) == "1" ? many : few;
}

}  // namespace stof::test

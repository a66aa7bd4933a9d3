#pragma once

#include <cstdlib>
#include <string_view>

namespace stof::test {

// Whether STOF_LONG=1 asks for the figures that take minutes.
inline bool long_tests() noexcept {
  const char* const asked = std::getenv("STOF_LONG");
  return asked != nullptr && std::string_view(asked) == "1";
}

}  // namespace stof::test

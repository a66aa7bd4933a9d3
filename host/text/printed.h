#pragma once

#include <optional>
#include <string>

namespace stof::host {

// What printf would print, of any length.
// clang-format off
[[gnu::format(printf, 1, 2)]] std::string printed(const char* format, ...);
// clang-format on

// Right-aligned in `width` columns; "-" for what is no number or is not finite.
std::string cell(std::optional<double> value, int width, int decimals);

}  // namespace stof::host

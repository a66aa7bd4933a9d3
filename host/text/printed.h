#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <string_view>

namespace stof::host {

// The units in which metres, radians and shares are printed.
inline constexpr double kMm = 1000;
inline constexpr double kCm = 100;
inline constexpr double kDegrees = 180 / std::numbers::pi;
inline constexpr double kPercent = 100;

// The text that printf would print, of any length.
// clang-format off
[[gnu::format(printf, 1, 2)]] std::string printed(const char* format, ...);
// clang-format on

// Appends to a list in one line, with the separator between two entries.
void add_to(std::string& list, std::string_view entry, std::string_view separator = ", ");

// Right-aligned in `width` columns; "-" for what is no number or is not finite.
std::string cell(std::optional<double> value, int width, int decimals);

}  // namespace stof::host

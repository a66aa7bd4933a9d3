#pragma once

#include <array>
#include <string_view>

#include "host/picture/png.h"

namespace stof::host {

// Of depths by their source, in the order of docs/WIRE.md: none, stereo, PMD, both, resolved,
// conflict. docs: host/README.md.
inline constexpr std::array<Rgb, 6> kSourceColours{
    {{14, 15, 18}, {66, 133, 200}, {238, 155, 40}, {58, 158, 92}, {150, 96, 190}, {206, 44, 52}}};
// Beside them, in pictures.
inline constexpr std::array<std::string_view, kSourceColours.size()> kSourceWords{
    "none", "stereo", "PMD", "both", "resolved", "conflict"};
inline constexpr const char* kSourceColoursInWords =
    "blue: stereo, orange: PMD, green: both agree, violet: resolved, red: conflict, black: none";

}  // namespace stof::host

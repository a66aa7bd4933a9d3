#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/wire/keys/key_table.h"

// Keys as the file that a sensor keeps, and a user: see "The key file" of docs/WIRE.md. No heap.
namespace stof::wire {

// Bounds every file: the first line, a line for each key, the check sum.
inline constexpr std::size_t kMostKeyText = 32 + KeyTable::kMost * 192;

// Writes the file into `space` (kMostKeyText). Returns what was written: wipe it when it is used.
std::span<char> write_keys(const KeyTable& keys, std::span<char> space) noexcept;

// Any bytes. kCorrupt: not such a file, or damaged: then `keys` is empty. kUnsupported: of a later
// version; the same.
Status read_keys(std::string_view text, KeyTable& keys) noexcept;

// "view", "tune", "admin"; kNone of any other text, and "none".
std::string_view role_text(Role role) noexcept;
Role role_of(std::string_view text) noexcept;

// The code of a label: 32 hexadecimal digits; hyphens, spaces and an end of line do not count.
std::optional<std::array<std::byte, 16>> code_of(std::string_view text) noexcept;

}  // namespace stof::wire

#include "firmware/settings/text/utf8.h"

#include <cstddef>
#include <cstdint>

namespace stof::settings {
namespace {

// Bytes of the character that begins with `first`; 0: none does.
std::size_t character_bytes(std::uint8_t first) noexcept {
  if (first < 0x80) {
    return 1;
  }
  if (first >= 0xC2 && first < 0xE0) {
    return 2;
  }
  if (first >= 0xE0 && first < 0xF0) {
    return 3;
  }
  return first >= 0xF0 && first < 0xF5 ? 4 : 0;
}

// Overlong forms, surrogates and what lies above U+10FFFF.
bool second_fits(std::uint8_t first, std::uint8_t second) noexcept {
  switch (first) {
    case 0xE0:
      return second >= 0xA0;
    case 0xED:
      return second < 0xA0;
    case 0xF0:
      return second >= 0x90;
    case 0xF4:
      return second < 0x90;
    default:
      return true;
  }
}

// Of characters that are not ASCII: what changes a line or the order of reading around it: C1
// controls, marks and embeddings of direction, separators of lines and paragraphs.
bool seen_as_text(std::uint32_t character) noexcept {
  const bool control = character >= 0x80 && character <= 0x9F;
  const bool direction = character == 0x061C || character == 0x200E || character == 0x200F ||
                         (character >= 0x202A && character <= 0x202E) ||
                         (character >= 0x2066 && character <= 0x2069);
  return !control && !direction && character != 0x2028 && character != 0x2029;
}

// Of `bytes` bytes that are well-formed.
std::uint32_t character_in(std::string_view text, std::size_t bytes) noexcept {
  constexpr std::uint32_t kFirstBits[]{0, 0x7F, 0x1F, 0x0F, 0x07};
  std::uint32_t character = static_cast<std::uint8_t>(text[0]) & kFirstBits[bytes];
  for (std::size_t k = 1; k < bytes; ++k) {
    character = character << 6U | (static_cast<std::uint8_t>(text[k]) & 0x3FU);
  }
  return character;
}

}  // namespace

bool plain_utf8(std::string_view text) noexcept {
  while (!text.empty()) {
    const auto first = static_cast<std::uint8_t>(text[0]);
    const std::size_t bytes = character_bytes(first);
    if (bytes == 0 || bytes > text.size() || first < 0x20 || first == 0x7F || first == '"' ||
        first == '\\') {
      return false;
    }
    for (std::size_t k = 1; k < bytes; ++k) {
      const auto next = static_cast<std::uint8_t>(text[k]);
      if (next < 0x80 || next >= 0xC0 || (k == 1 && !second_fits(first, next))) {
        return false;
      }
    }
    if (bytes > 1 && !seen_as_text(character_in(text, bytes))) {
      return false;
    }
    text.remove_prefix(bytes);
  }
  return true;
}

}  // namespace stof::settings

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
    text.remove_prefix(bytes);
  }
  return true;
}

}  // namespace stof::settings

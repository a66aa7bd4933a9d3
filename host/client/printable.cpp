#include "host/client/printable.h"

#include <array>
#include <cstddef>

namespace stof::client {
namespace {

// Characters without a width, and those that turn the direction of what follows: a name with them
// may look like another one (Unicode Standard Annex 9 and Technical Report 36).
bool hidden(unsigned code) {
  return (code >= 0x200b && code <= 0x200f) || (code >= 0x2028 && code <= 0x202e) ||
         (code >= 0x2060 && code <= 0x206f) || code == 0x061c || code == 0xfeff;
}

// Bytes of the character of UTF-8 that the text begins with and that does not control a terminal;
// 0: there is none.
std::size_t harmless(std::string_view text) {
  const auto byte = [text](std::size_t at) {
    return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) {
    return first >= 0x20 && first != 0x7f ? 1 : 0;
  }
  constexpr std::array<unsigned, 5> kLeast{0, 0, 0xa0, 0x800, 0x10000};  // below 0xa0: C1
  const std::size_t length = 2 + (first >= 0xe0 ? 1U : 0U) + (first >= 0xf0 ? 1U : 0U);
  if (first < 0xc2 || first > 0xf4) {
    return 0;
  }
  unsigned code = first & (0xffU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) {
      return 0;
    }
    code = code << 6 | (byte(i) & 0x3f);
  }
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return code >= kLeast[length] && code <= 0x10ffff && !surrogate && !hidden(code) ? length : 0;
}

}  // namespace

std::string printable(std::string_view text, Lines lines) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const bool end_of_line = lines == Lines::kSeveral && text.front() == '\n';
    const std::size_t length = end_of_line ? 1 : harmless(text);
    if (length == 0) {
      out += '?';
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

}  // namespace stof::client

#pragma once

#include <string_view>

namespace stof::settings {

// Well-formed UTF-8 (RFC 3629) that JSON need not escape: no control characters, quotes or
// backslashes; nor characters that change the direction of text or end a line.
bool plain_utf8(std::string_view text) noexcept;

}  // namespace stof::settings

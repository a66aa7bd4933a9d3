#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace stof::client {

enum class Lines : std::uint8_t { kOne, kSeveral };

// Text from the network for a terminal: what could control it (C0 and C1 characters, DEL), what is
// not seen or turns the direction of writing, and what is no UTF-8 becomes a question mark for each
// byte; with kSeveral, the ends of lines stay.
std::string printable(std::string_view text, Lines lines = Lines::kOne);

}  // namespace stof::client

#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace stof::settings {

// Bytes may be looked at as char.
inline std::string_view as_text(std::span<const std::byte> bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};  // NOLINT: as above
}
inline std::span<char> as_writable_text(std::span<std::byte> bytes) noexcept {
  return {reinterpret_cast<char*>(bytes.data()), bytes.size()};  // NOLINT: as above
}

}  // namespace stof::settings

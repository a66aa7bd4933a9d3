#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace stof::settings {

// At most kSize - 1 bytes of UTF-8, filled up with 0.
template <std::size_t kSize>
class Text {
 public:
  constexpr Text() = default;
  // Cut off where it is longer.
  constexpr explicit Text(std::string_view text) noexcept {
    std::ranges::copy(text.substr(0, kSize - 1), bytes_.begin());
  }
  constexpr std::string_view view() const noexcept { return {bytes_.data()}; }
  // Ends with a 0.
  constexpr const char* c_str() const noexcept { return bytes_.data(); }
  friend bool operator==(const Text&, const Text&) = default;

 private:
  std::array<char, kSize> bytes_{};
};

}  // namespace stof::settings

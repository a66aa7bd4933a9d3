#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <type_traits>

namespace stof::dsp {

// The number that all of `text` is; nothing: it is no number of this type.
template <typename T>
std::optional<T> parse_number(std::string_view text, int base = 10) noexcept {
  T value{};
  const char* const end = text.data() + text.size();
  std::from_chars_result result{};
  if constexpr (std::is_integral_v<T>) {
    result = std::from_chars(text.data(), end, value, base);
  } else {
    result = std::from_chars(text.data(), end, value);
  }
  return result.ec == std::errc{} && result.ptr == end ? std::optional(value) : std::nullopt;
}

// A number in [low, high].
template <typename T>
std::optional<T> parse_number_in(std::string_view text, std::type_identity_t<T> low,
                                 std::type_identity_t<T> high) noexcept {
  const std::optional<T> value = parse_number<T>(text);
  return value && *value >= low && *value <= high ? value : std::nullopt;
}

}  // namespace stof::dsp

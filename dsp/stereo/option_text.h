#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "dsp/base/parse_number.h"

// How the values of options are written. false, or nothing: not one of them, and `to` stays.
namespace stof::dsp::option_text {

inline bool set_number(std::string_view text, int low, int high, int& to) noexcept {
  const std::optional<int> value = parse_number_in<int>(text, low, high);
  to = value.value_or(to);
  return value.has_value();
}

inline bool set_limit(std::string_view text, int low, int high, std::optional<int>& to) noexcept {
  const std::optional<int> value = parse_number_in<int>(text, low, high);
  if (!value && text != "off") {
    return false;
  }
  to = value;
  return true;
}

inline bool set_switch(std::string_view text, bool& to) noexcept {
  if (text != "on" && text != "off") {
    return false;
  }
  to = text == "on";
  return true;
}

template <typename T>
struct Named {
  std::string_view name;
  T value;
};

template <typename T, std::size_t kCount>
bool set_named(std::string_view text, const std::array<Named<T>, kCount>& names, T& to) noexcept {
  const auto* const found = std::ranges::find(names, text, &Named<T>::name);
  if (found == names.end()) {
    return false;
  }
  to = found->value;
  return true;
}

}  // namespace stof::dsp::option_text

#include "host/lib/json_text.h"

#include <algorithm>
#include <cstddef>

namespace stof::lib {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

void skip_space(std::string_view& text) noexcept {
  text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
}

bool take(std::string_view& text, char sign) noexcept {
  skip_space(text);
  if (text.empty() || text.front() != sign) {
    return false;
  }
  text.remove_prefix(1);
  return true;
}

// Bytes of the string that begins here, with its quotes; 0: it does not end.
std::size_t string_bytes(std::string_view text) noexcept {
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '\\') {
      ++i;
    } else if (text[i] == '"') {
      return i + 1;
    }
  }
  return 0;
}

// Of an object or an array, up to the bracket that closes it.
std::size_t group_bytes(std::string_view text) noexcept {
  std::size_t depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char sign = text[i];
    if (sign == '"') {
      const std::size_t bytes = string_bytes(text.substr(i));
      if (bytes == 0) {
        return 0;
      }
      i += bytes - 1;
    } else if (sign == '{' || sign == '[') {
      ++depth;
    } else if ((sign == '}' || sign == ']') && --depth == 0) {
      return i + 1;
    }
  }
  return 0;
}

std::optional<std::string_view> take_value(std::string_view& text) noexcept {
  skip_space(text);
  if (text.empty()) {
    return std::nullopt;
  }
  std::size_t bytes = 0;
  if (text.front() == '"') {
    bytes = string_bytes(text);
  } else if (text.front() == '{' || text.front() == '[') {
    bytes = group_bytes(text);
  } else {
    bytes = std::min(text.find_first_of(",:]} \t\r\n"), text.size());
  }
  if (bytes == 0) {
    return std::nullopt;
  }
  const std::string_view value = text.substr(0, bytes);
  text.remove_prefix(bytes);
  return value;
}

}  // namespace

std::optional<std::string_view> json_member(std::string_view object,
                                            std::string_view name) noexcept {
  if (!take(object, '{')) {
    return std::nullopt;
  }
  do {
    const auto key = take_value(object);
    if (!key || !take(object, ':')) {
      return std::nullopt;
    }
    const auto value = take_value(object);
    if (!value || json_string(*key) == name) {
      return value;
    }
  } while (take(object, ','));
  return std::nullopt;
}

std::optional<std::string_view> json_at(std::string_view object, std::string_view path,
                                        std::string_view between) noexcept {
  std::optional<std::string_view> node = object;
  while (node) {
    if (!between.empty()) {
      node = json_member(*node, between);
    }
    const std::size_t dot = path.find('.');
    node = node ? json_member(*node, path.substr(0, dot)) : std::nullopt;
    if (dot == std::string_view::npos) {
      break;
    }
    path.remove_prefix(dot + 1);
  }
  return node;
}

std::optional<std::string_view> json_next(std::string_view& array) noexcept {
  if (!take(array, '[') && !take(array, ',')) {
    return std::nullopt;
  }
  return take_value(array);
}

std::string_view json_string(std::string_view value) noexcept {
  return value.size() >= 2 && value.front() == '"' ? value.substr(1, value.size() - 2) : value;
}

}  // namespace stof::lib

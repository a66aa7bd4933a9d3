#include "host/text/printed.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace stof::host {

std::string printed(const char* format, ...) {
  // NOLINTBEGIN(cppcoreguidelines-init-variables): va_start and va_copy do
  va_list values;
  va_start(values, format);
  va_list again;
  va_copy(again, values);
  // NOLINTEND(cppcoreguidelines-init-variables)
  const int size = std::vsnprintf(nullptr, 0, format, values);
  va_end(values);
  std::string text(static_cast<std::size_t>(size < 0 ? 0 : size), '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  return text;
}

void add_to(std::string& list, std::string_view entry, std::string_view separator) {
  list.append(list.empty() ? "" : separator).append(entry);
}

std::string cell(std::optional<double> value, int width, int decimals) {
  return value && std::isfinite(*value) ? printed("%*.*f", width, decimals, *value)
                                        : printed("%*s", width, "-");
}

}  // namespace stof::host

#pragma once

#include <cstddef>
#include <string_view>

#include "firmware/settings/fields/field.h"

namespace stof::settings {

// Calls visitor.open("depth"), .field(...), .close() in the order of the table, so that each group
// is opened and closed once.
template <typename Visitor>
void visit_field_tree(Visitor& visitor) noexcept {
  std::string_view open;
  const auto close_until_within = [&](std::string_view group) {
    while (!open.empty() &&
           !(group == open || (group.starts_with(open) && group[open.size()] == '.'))) {
      visitor.close();
      const std::size_t dot = open.rfind('.');
      open = dot == std::string_view::npos ? std::string_view() : open.substr(0, dot);
    }
  };
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    const Field next = field(place);
    close_until_within(next.group);
    while (open.size() < next.group.size()) {
      const std::size_t begin = open.empty() ? 0 : open.size() + 1;
      const std::size_t end = next.group.find('.', begin);
      open = next.group.substr(0, end);
      visitor.open(open.substr(begin));
    }
    visitor.field(next);
  }
  close_until_within({});
}

}  // namespace stof::settings

#pragma once

#include <cstddef>
#include <string_view>

#include "firmware/settings/fields/field_value.h"
#include "firmware/settings/text/paged_writer.h"

namespace stof::settings {

// Gets the parts of a JSON document, in their order.
class JsonVisitor {
 public:
  virtual ~JsonVisitor() = default;
  // Whether the member of that path, an object, is one whose members are visited too.
  virtual bool is_group(std::string_view path) noexcept = 0;
  // Every other member, in the order of the text. `path` is joined by dots: "depth.match.lr".
  // false ends the walk; the visitor has said why.
  virtual bool member(std::string_view path, const Value& value) noexcept = 0;
};

inline constexpr std::size_t kMostJsonBytes = 65'535;
inline constexpr int kMostJsonDepth = 4;  // objects within each other

// Any bytes: one JSON object (RFC 8259) and white space. Stricter than that: no name twice in an
// object, names of a-z, 0-9, _ and - alone, no escapes in strings. Members are visited before the
// end of the text has been seen. false: `why` says in one line what is wrong and where.
bool walk_json(std::string_view text, JsonVisitor& visitor, PagedWriter& why) noexcept;

}  // namespace stof::settings

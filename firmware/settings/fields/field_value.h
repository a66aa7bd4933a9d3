#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/settings/fields/field.h"
#include "firmware/settings/settings.h"
#include "firmware/settings/text/paged_writer.h"

// The value of a field: from what somebody wrote, and as text.
namespace stof::settings {

// The value of a field of depth.match that changes nothing of the preset.
inline constexpr std::string_view kAsPreset = "preset";

// The kind of a written value.
enum class Written : std::uint8_t {
  kString,
  kNumber,  // as JSON has it, perhaps with fraction and exponent
  kBoolean,
  kNull,
  kObject,
  kArray,
  kBare,  // on a command line: whatever suits the field
};
struct Value {
  Written written = Written::kBare;
  std::string_view text;  // of a string without its quotes
};

// false: not one of the field's values, nothing changed.
bool assign(const Field& field, const Value& value, Settings& settings) noexcept;
// "off, raw or rvl".
void write_takes(const Field& field, PagedWriter& out) noexcept;
// As JSON: "rvl" with its quotes, 12, true.
void write_value(const Field& field, const Settings& settings, PagedWriter& out) noexcept;
bool equal(const Field& field, const Settings& a, const Settings& b) noexcept;
// The field's value in `from`.
void copy_field(const Field& field, const Settings& from, Settings& to) noexcept;

}  // namespace stof::settings

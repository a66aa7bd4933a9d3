#include "firmware/settings/fields/schema.h"

#include <cstddef>
#include <string_view>

#include "firmware/settings/fields/field_tree.h"
#include "firmware/settings/fields/field_value.h"
#include "firmware/settings/fields/presets.h"

namespace stof::settings {
namespace {

constexpr Settings kDefaults{};

void write_path(const Field& field, PagedWriter& out) noexcept {
  out << field.group << (field.group.empty() ? "" : ".") << field.name;
}

std::string_view json_type(Kind kind) noexcept {
  switch (kind) {
    case Kind::kInteger:
      return R"("integer")";
    case Kind::kBoolean:
      return R"("boolean")";
    case Kind::kMatch:
      return R"(["string", "integer", "boolean"])";
    default:
      return R"("string")";
  }
}

// The role that it takes; anybody: on a sensor that is not paired.
std::string_view changed_by(Access access) noexcept {
  if (access == Access::kAdmin) {
    return "admin";
  }
  return access == Access::kTune ? "tune" : "anybody";
}

class SchemaWriter {
 public:
  explicit SchemaWriter(PagedWriter& out) noexcept : out_(out) {}

  void open(std::string_view name) noexcept {
    begin_member();
    out_ << '"' << name
         << R"(": {"type": "object", "additionalProperties": false, "properties": {)";
    ++depth_;
    first_ = true;
  }
  void close() noexcept {
    --depth_;
    out_ << '\n';
    indent();
    out_ << "}}";
    first_ = false;
  }
  void field(const Field& field) noexcept {
    begin_member();
    out_ << '"' << field.name << R"(": {"type": )" << json_type(field.kind);
    write_limits(field);
    out_ << R"(, "default": )";
    write_value(field, kDefaults, out_);
    out_ << R"(, "description": ")" << field.meaning;
    if (field.option != nullptr) {
      out_ << ": ";
      write_takes(field, out_);
    }
    out_ << '"';
    if (!field.unit.empty()) {
      out_ << R"(, "x-unit": ")" << field.unit << '"';
    }
    out_ << R"(, "x-applies": ")" << (field.applies == Applies::kNow ? "now" : "restart")
         << R"(", "x-changed-by": ")" << changed_by(field.access) << "\"}";
    first_ = false;
  }

 private:
  void write_limits(const Field& field) noexcept {
    switch (field.kind) {
      case Kind::kInteger:
        out_ << R"(, "minimum": )" << field.low << R"(, "maximum": )" << field.high;
        break;
      case Kind::kChoice:
        out_ << R"(, "enum": [)";
        for (std::size_t k = 0; k < field.values.size(); ++k) {
          out_ << (k > 0 ? ", \"" : "\"") << field.values[k] << '"';
        }
        out_ << ']';
        break;
      case Kind::kText:
        out_
            << R"(, "minLength": )" << field.low << R"(, "maxLength": )" << field.high
            << R"(, "pattern": "^[^\u0000-\u001f\u007f-\u009f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\"\\\\]*$")";
        break;
      case Kind::kDevice:
        out_
            << R"(, "maxLength": )" << field.high
            << R"(, "pattern": "^(/dev/(?!.*\\.\\.)[^\u0000-\u001f\u007f-\u009f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\"\\\\]+)?$")";
        break;
      case Kind::kInterface:
        out_ << R"(, "pattern": "^([0-9]{1,3}(\\.[0-9]{1,3}){3}/[0-9]{1,2})?$")";
        break;
      case Kind::kIpv4:
        out_ << R"(, "pattern": "^([0-9]{1,3}(\\.[0-9]{1,3}){3})?$")";
        break;
      case Kind::kHostname:
        out_ << R"(, "pattern": "^[a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?$")";
        break;
      case Kind::kBoolean:
      case Kind::kMatch:
        break;
    }
  }
  void begin_member() noexcept {
    out_ << (first_ ? "\n" : ",\n");
    indent();
  }
  void indent() noexcept {
    for (int k = 0; k < depth_; ++k) {
      out_ << "  ";
    }
  }

  PagedWriter& out_;
  int depth_ = 2;
  bool first_ = true;
};

// A cell of a table of Markdown may not hold a bare bar.
void write_cell(std::string_view text, PagedWriter& out) noexcept {
  for (const char c : text) {
    out << (c == '|' ? "\\" : "") << c;
  }
}

void write_row(const Field& field, PagedWriter& out) noexcept {
  out << "| `";
  write_path(field, out);
  out << "` | ";
  if (field.kind == Kind::kText) {
    out << "text of " << field.low << " to " << field.high << " bytes";
  } else {
    write_takes(field, out);
  }
  out << (field.unit.empty() ? "" : " ") << field.unit << " | `";
  write_value(field, kDefaults, out);
  out << "` | " << (field.applies == Applies::kNow ? "now" : "restart") << " | "
      << changed_by(field.access) << " | ";
  write_cell(field.meaning, out);
  out << " |\n";
}

void write_tables(PagedWriter& out) {
  out << "| setting | takes | default | applies | role | is |\n| --- | --- | --- | --- | --- | --- "
         "|\n";
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    write_row(field(place), out);
  }
  out << '\n';
  write_preset_table(out);
}

std::string whole(void (*write)(PagedWriter&)) {
  PagedWriter count({});
  write(count);
  std::string text(count.total(), '\0');
  PagedWriter out(text);
  write(out);
  return text;
}

}  // namespace

void write_schema(PagedWriter& out) noexcept {
  out << "{\n"
         "  \"$schema\": \"https://json-schema.org/draft/2020-12/schema\",\n"
         "  \"title\": \"Settings of a stof sensor\",\n"
         "  \"type\": \"object\",\n"
         "  \"additionalProperties\": false,\n"
         "  \"properties\": {";
  SchemaWriter writer(out);
  visit_field_tree(writer);
  out << "\n  }\n}\n";
}

std::string settings_schema() { return whole(&write_schema); }

std::string settings_tables() { return whole(&write_tables); }

}  // namespace stof::settings

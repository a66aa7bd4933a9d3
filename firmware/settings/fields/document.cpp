#include "firmware/settings/fields/document.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "firmware/settings/fields/field_tree.h"
#include "firmware/settings/fields/field_value.h"
#include "firmware/settings/text/json.h"
#include "firmware/wire/crc32c.h"

namespace stof::settings {
namespace {

// Options of the matcher that this version has not, or not with all values they once had: a
// document that names them is still read.
constexpr std::array<std::string_view, 7> kLeft{"method", "cost",    "shape",   "directions",
                                                "band",   "pyramid", "interest"};
constexpr std::string_view kMatch = "depth.match.";
constexpr Access kLeftAccess = Access::kTune;  // as such options had

bool has_left(std::string_view path) noexcept {
  return path.starts_with(kMatch) &&
         std::ranges::find(kLeft, path.substr(kMatch.size())) != kLeft.end();
}

void note_left(std::string_view path, std::string_view value, PagedWriter& notes) noexcept {
  if (value != kAsPreset) {
    note_fallback(path, kNotInThisVersion, notes);
  }
}

// P1,P2 or P1,P2,OCCLUSION of any size.
bool once_took(std::string_view path, const Value& value) noexcept {
  return path == "depth.match.penalties" &&
         (value.written == Written::kString || value.written == Written::kBare) &&
         !value.text.empty() && value.text.size() <= kMatchBytes && value.text.contains(',') &&
         value.text.find_first_not_of("0123456789,") == std::string_view::npos;
}

bool refuse_unknown(std::string_view path, PagedWriter& why) noexcept {
  if (is_group(path)) {
    why << path << ": takes an object of settings";
  } else if (path == "depth.match.fill") {
    why << path << ": what is made up is not published: leave it out";
  } else {
    write_quoted(path, why);
    why << ": there is no such setting";
  }
  return false;
}

bool take(std::size_t place, std::string_view path, const Value& value, Settings& settings,
          PagedWriter& notes, PagedWriter& why) noexcept {
  const Field known = field(place);
  if (assign(known, value, settings)) {
    return true;
  }
  if (once_took(path, value)) {
    settings.depth.match[known.slot] = {};
    note_fallback(path, kNotInThisVersion, notes);
    return true;
  }
  why << path << ": takes ";
  write_takes(known, why);
  why << ", not ";
  if (value.written == Written::kObject || value.written == Written::kArray) {
    why << (value.written == Written::kObject ? "an object" : "an array");
    return false;
  }
  const bool quoted = value.written == Written::kString || value.written == Written::kBare;
  (quoted ? write_quoted : write_clipped)(value.text, why);
  return false;
}

class DocumentReader final : public JsonVisitor {
 public:
  DocumentReader(Settings& settings, FieldSet& named, PagedWriter& notes, PagedWriter& why) noexcept
      : settings_(settings), named_(named), notes_(notes), why_(why) {}
  const FellBack& fell_back() const noexcept { return fell_back_; }

  bool is_group(std::string_view path) noexcept override { return settings::is_group(path); }
  bool member(std::string_view path, const Value& value) noexcept override {
    const std::size_t place = find_field(path);
    const std::size_t told = notes_.total();
    if (place == field_count() && has_left(path)) {
      note_left(path, value.text, notes_);
      note(path, kLeftAccess, told);
      return true;
    }
    if (place == field_count()) {
      return refuse_unknown(path, why_);
    }
    named_.set(place);
    const bool taken = take(place, path, value, settings_, notes_, why_);
    note(path, field(place).access, told);
    return taken;
  }

 private:
  // told: of the notes before this member, which adds one where it falls back.
  void note(std::string_view path, Access access, std::size_t told) noexcept {
    if (notes_.total() > told && access > fell_back_.access) {
      fell_back_ = {.access = access, .path = Text<64>(path)};
    }
  }

  Settings& settings_;
  FieldSet& named_;
  PagedWriter& notes_;  // of fields that fell back: told where nothing is refused
  PagedWriter& why_;
  FellBack fell_back_;
};

class DocumentWriter {
 public:
  DocumentWriter(const Settings& settings, PagedWriter& out) noexcept
      : settings_(settings), out_(out) {}

  void open(std::string_view name) noexcept {
    begin_member(name);
    out_ << '{';
    ++depth_;
    first_ = true;
  }
  void close() noexcept {
    --depth_;
    begin_line();
    out_ << '}';
    first_ = false;
  }
  void field(const Field& field) noexcept {
    begin_member(field.name);
    write_value(field, settings_, out_);
    first_ = false;
  }

 private:
  void begin_line() noexcept {
    out_ << '\n';
    for (int k = 0; k < depth_; ++k) {
      out_ << "  ";
    }
  }
  void begin_member(std::string_view name) noexcept {
    out_ << (first_ ? "" : ",");
    begin_line();
    out_ << '"' << name << "\": ";
  }

  const Settings& settings_;
  PagedWriter& out_;
  int depth_ = 1;
  bool first_ = true;
};

}  // namespace

// The names of several share the words behind the first, so that a line takes all of them.
void note_fallback(std::string_view path, std::string_view cause, PagedWriter& note) noexcept {
  const std::string_view before{note.text().data(), note.text().size()};
  if (cause == kNotInThisVersion && before.contains(cause)) {
    note << "; " << path << " too";
    return;
  }
  note << (before.empty() ? "" : "; ") << path << ": " << cause << ": as the preset has it";
}

bool parse(std::span<const char> text, Settings& settings, PagedWriter& why, FieldSet* named,
           FellBack* fell_back) noexcept {
  Settings changed = settings;
  FieldSet fields;
  std::array<char, kWhyBytes> space;
  PagedWriter notes(space);
  DocumentReader reader(changed, fields, notes, why);
  if (!walk_json({text.data(), text.size()}, reader, why)) {
    return false;
  }
  why << notes.text();
  settings = changed;
  if (named != nullptr) {
    *named |= fields;
  }
  if (fell_back != nullptr) {
    *fell_back = reader.fell_back();
  }
  return true;
}

bool parse_field(std::string_view path, std::string_view value, Settings& settings,
                 PagedWriter& why) noexcept {
  const std::size_t place = find_field(path);
  if (place == field_count() && has_left(path)) {
    note_left(path, value, why);
    return true;
  }
  return place == field_count() ? refuse_unknown(path, why)
                                : take(place, path, {.text = value}, settings, why, why);
}

void write_document(const Settings& settings, PagedWriter& out) noexcept {
  out << '{';
  DocumentWriter writer(settings, out);
  visit_field_tree(writer);
  out << "\n}\n";
}

std::uint32_t fingerprint(const Settings& settings) noexcept {
  std::array<char, kMostDocumentBytes> space;
  PagedWriter document(space);
  write_document(settings, document);
  return wire::crc32c(std::as_bytes(std::span(document.text())));
}

}  // namespace stof::settings

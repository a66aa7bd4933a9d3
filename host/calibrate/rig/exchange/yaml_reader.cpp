#include "host/calibrate/rig/exchange/yaml_reader.h"

#include <algorithm>
#include <cmath>

#include "dataset/files/file.h"
#include "dsp/base/parse_number.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kMaxDepth = 64;  // of brackets: yaml-cpp recurses

bool too_deep(std::string_view text) {
  std::size_t depth = 0;
  for (const char c : text) {
    depth += c == '[' || c == '{' ? 1 : 0;
    depth -= (c == ']' || c == '}') && depth > 0 ? 1 : 0;
    if (depth > kMaxDepth) {
      return true;
    }
  }
  return false;
}

// Nested blocks: "- - - -" and ever deeper indentation.
bool too_deep_blocks(std::string_view text) {
  std::size_t run = 0;
  for (const char c : text) {
    run = c == ' ' || c == '-' || c == '?' || c == ':' ? run + 1 : 0;
    if (run > 4 * kMaxDepth) {
      return true;
    }
  }
  return false;
}

// Messages are one line, whatever the file quotes.
std::string one_line(std::string text) {
  std::ranges::replace_if(text, [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return text;
}

// How often a map has a name: YAML says once, and readers differ in which one they take.
std::size_t times_named(const YAML::Node& map, std::string_view key) {
  std::size_t times = 0;
  for (const auto& entry : map) {
    if (entry.first.IsScalar() && entry.first.Scalar() == key) {
      ++times;
    }
  }
  return times;
}

}  // namespace

dataset::Loaded<YamlReader> YamlReader::of(const NamedText& named) {
  const std::filesystem::path& file = named.file;
  std::string text = named.text;
  // Blanked, not cut out: lines keep their numbers.
  constexpr std::string_view kDirective = "%YAML:1.0";
  if (text.starts_with(kDirective)) {
    text.replace(0, kDirective.size(), kDirective.size(), ' ');
  }
  if (text.starts_with("<?xml")) {
    return dataset::refuse(file, "line 1: is XML", "export it as YAML or JSON");
  }
  if (too_deep(text) || too_deep_blocks(text)) {
    return dataset::refuse(file, "is nested too deeply for a calibration", "export it again");
  }
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) {
      return dataset::refuse(file, "line 1: is no YAML with names", "give a calibration in YAML");
    }
    return YamlReader(file, root);
  } catch (const YAML::Exception& error) {
    return dataset::refuse(
        file, printed("line %d: is no YAML (%s)", error.mark.line + 1, one_line(error.msg).c_str()),
        "export it again");
  }
}

void YamlReader::fail(const YAML::Node& node, std::string what, std::string remedy) {
  if (failed()) {
    return;
  }
  // A node that is not there throws when asked where it is.
  const int line = node.IsDefined() ? node.Mark().line + 1 : 0;
  const std::string where = line > 0 ? printed("line %d: ", line) : "";
  problem_ = dataset::refuse(file_, where + what, remedy).error();
}

YAML::Node YamlReader::at(const char* key) { return in(root_, key); }

YAML::Node YamlReader::in(const YAML::Node& parent, const char* key) {
  if (failed() || !parent.IsDefined()) {
    return YAML::Node(YAML::NodeType::Undefined);
  }
  if (!parent.IsMap() || !parent[key].IsDefined()) {
    fail(parent, std::string("has no ") + key, "export it again");
    return YAML::Node(YAML::NodeType::Undefined);
  }
  if (times_named(parent, key) > 1) {
    fail(parent[key], std::string("has ") + key + " more than once", "leave one of them");
    return YAML::Node(YAML::NodeType::Undefined);
  }
  return parent[key];
}

double YamlReader::number(const YAML::Node& node, const char* name) {
  if (failed() || !node.IsDefined()) {
    return 0;
  }
  const std::optional<double> value =
      node.IsScalar() ? dsp::parse_number<double>(node.Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value)) {
    fail(node, std::string("has in ") + name + " what is no number", "export it again");
    return 0;
  }
  return *value;
}

std::vector<double> YamlReader::numbers(const YAML::Node& node, const char* name, std::size_t least,
                                        std::size_t most) {
  std::vector<double> values;
  if (failed() || !node.IsDefined()) {
    return std::vector<double>(most);
  }
  YAML::Node data = node;
  if (node.IsMap()) {
    data.reset(in(node, "data"));
  }
  if (!failed() && !data.IsSequence()) {
    fail(node, std::string("has a ") + name + " that is no list", "export it again");
  }
  if (failed()) {
    return std::vector<double>(most);
  }
  for (const YAML::Node& value : data) {
    values.push_back(number(value, name));
  }
  if (values.size() < least || values.size() > most) {
    fail(node, printed("has %zu numbers in %s, not %zu", values.size(), name, least),
         "export it again");
  }
  if (node.IsMap()) {
    require_rows(node, name, values.size());
  }
  values.resize(most);
  return values;
}

void YamlReader::require_rows(const YAML::Node& matrix, const char* name, std::size_t count) {
  const double rows = number(in(matrix, "rows"), name);
  const double columns = number(in(matrix, "cols"), name);
  if (!failed() && rows * columns != static_cast<double>(count)) {
    fail(matrix, printed("has %zu numbers in %s, not %g rows of %g", count, name, rows, columns),
         "export it again");
  }
}

std::vector<double> YamlReader::rows(const YAML::Node& node, const char* name, std::size_t count,
                                     std::size_t columns) {
  std::vector<double> values;
  if (!failed() && node.IsDefined() && (!node.IsSequence() || node.size() != count)) {
    fail(node, printed("has a %s that is no %zu rows", name, count), "export it again");
  }
  if (failed() || !node.IsDefined()) {
    return std::vector<double>(count * columns);
  }
  for (const YAML::Node& row : node) {
    const std::vector<double> of_row = numbers(row, name, columns, columns);
    values.insert(values.end(), of_row.begin(), of_row.end());
  }
  return values;
}

int YamlReader::integer(const YAML::Node& node, const char* name) {
  const double value = number(node, name);
  if (!failed() && (!(value >= 1) || !(value <= 65536) || value != std::floor(value))) {
    fail(node, std::string("has a ") + name + " that is no whole number of 1 to 65536",
         "export it again");
  }
  return failed() ? 0 : static_cast<int>(value);
}

std::string YamlReader::word(const YAML::Node& node, const char* name) {
  if (failed() || !node.IsDefined()) {
    return {};
  }
  constexpr std::size_t kLongest = 64;
  const bool printable =
      node.IsScalar() && node.Scalar().size() <= kLongest &&
      std::ranges::all_of(node.Scalar(), [](char c) { return c >= ' ' && c <= '~'; });
  if (!printable) {
    fail(node, std::string("has a ") + name + " that is no word", "export it again");
    return {};
  }
  return node.Scalar();
}

std::string exact(double value) {
  // YAML 1.1 readers take 1 for a whole number; OpenCV writes "1." then.
  std::string text = printed("%.17g", value);
  if (text.find_first_of(".eE") == std::string::npos) {
    text += ".0";
  }
  return text;
}

std::string exact_list(const std::vector<double>& values) {
  std::string list;
  for (const double value : values) {
    add_to(list, exact(value));
  }
  return "[" + list + "]";
}

}  // namespace stof::host

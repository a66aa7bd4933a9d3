#include "host/bridge/type_hash.h"

#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <sodium.h>

namespace stof::bridge {
namespace {

// type_description_interfaces/msg/FieldType.
constexpr std::array<std::pair<std::string_view, int>, 13> kTypeIds{{{"int8", 2},
                                                                     {"uint8", 3},
                                                                     {"int16", 4},
                                                                     {"uint16", 5},
                                                                     {"int32", 6},
                                                                     {"uint32", 7},
                                                                     {"int64", 8},
                                                                     {"uint64", 9},
                                                                     {"float32", 10},
                                                                     {"float64", 11},
                                                                     {"bool", 15},
                                                                     {"byte", 16},
                                                                     {"string", 17}}};
constexpr int kNested = 1;
constexpr int kArray = 48;
constexpr int kUnboundedSequence = 144;

struct Field {
  std::string name{};
  int type_id = 0;
  unsigned capacity = 0;
  std::string nested{};  // full name, of kNested
};
using Fields = std::vector<Field>;
using Types = std::map<std::string, Fields>;  // by full name

// "std_msgs/msg/Header" of "std_msgs/Header".
std::string full_name(std::string_view name) {
  const std::size_t slash = name.find('/');
  const bool is_short =
      slash != std::string_view::npos && name.find('/', slash + 1) == std::string_view::npos;
  return is_short ? std::string(name.substr(0, slash)) + "/msg" + std::string(name.substr(slash))
                  : std::string(name);
}

// "float64[9] k"; nothing: not a type of ours.
std::optional<Field> field_of(std::string_view type, std::string name) {
  Field field{.name = std::move(name)};
  const std::size_t bracket = type.find('[');
  if (bracket != std::string_view::npos) {
    const std::string_view size = type.substr(bracket + 1, type.size() - bracket - 2);
    const auto [end, error] =
        std::from_chars(size.data(), size.data() + size.size(), field.capacity);
    if (!size.empty() && (error != std::errc{} || end != size.data() + size.size())) {
      return std::nullopt;
    }
    field.type_id = size.empty() ? kUnboundedSequence : kArray;
    type = type.substr(0, bracket);
  }
  for (const auto& [known, id] : kTypeIds) {
    if (type == known) {
      field.type_id += id;
      return field;
    }
  }
  if (type.find('/') == std::string_view::npos) {
    return std::nullopt;
  }
  field.type_id += kNested;
  field.nested = full_name(type);
  return field;
}

// All types of a schema.
std::optional<Types> types_of(const mcap::Schema& schema) {
  Types types;
  Fields* fields = &types[full_name(schema.name)];
  std::istringstream lines(schema.data);
  for (std::string line; std::getline(lines, line);) {
    constexpr std::string_view kMessage = "MSG: ";
    if (line.starts_with(kMessage)) {
      fields = &types[full_name(std::string_view(line).substr(kMessage.size()))];
      continue;
    }
    std::istringstream words(line.substr(0, line.find('#')));
    std::string type;
    std::string name;
    words >> type >> name;
    const bool is_constant = name.find('=') != std::string::npos;
    if (name.empty() || is_constant) {
      continue;  // or the line between two types
    }
    std::optional<Field> field = field_of(type, name);
    if (!field) {
      return std::nullopt;
    }
    fields->push_back(std::move(*field));
  }
  return types;
}

// All that a type is made of, itself left out.
bool collect(const Types& types, const std::string& name, std::set<std::string>& found) {
  const auto type = types.find(name);
  if (type == types.end()) {
    return false;
  }
  for (const Field& field : type->second) {
    if (!field.nested.empty() && found.insert(field.nested).second &&
        !collect(types, field.nested, found)) {
      return false;
    }
  }
  return true;
}

std::string description(const std::string& name, const Fields& fields) {
  std::string json = R"({"type_name": ")" + name + R"(", "fields": [)";
  for (const Field& field : fields) {
    json += std::string(&field == fields.data() ? "" : ", ") + R"({"name": ")" + field.name +
            R"(", "type": {"type_id": )" + std::to_string(field.type_id) + R"(, "capacity": )" +
            std::to_string(field.capacity) + R"(, "string_capacity": 0, "nested_type_name": ")" +
            field.nested + R"("}})";
  }
  return json + "]}";
}

}  // namespace

std::string type_hash(const mcap::Schema& schema) {
  const std::optional<Types> types = types_of(schema);
  const std::string name = full_name(schema.name);
  std::set<std::string> parts;
  if (!types || !collect(*types, name, parts)) {
    return {};
  }
  std::string json = R"({"type_description": )" + description(name, types->at(name)) +
                     R"(, "referenced_type_descriptions": [)";
  for (const std::string& part : parts) {
    json += (part == *parts.begin() ? "" : ", ") + description(part, types->at(part));
  }
  json += "]}";
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(json.data()), json.size());
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), hash.data(), hash.size());
  return std::string("RIHS01_") + hex.data();
}

std::string dds_type_name(const std::string& ros_name) {
  std::string name = ros_name;
  for (std::size_t at = 0; (at = name.find('/', at)) != std::string::npos;) {
    name.replace(at, 1, "::");
  }
  const std::size_t last = name.rfind("::");
  return last == std::string::npos ? name : name.insert(last, "::dds_") + "_";
}

}  // namespace stof::bridge

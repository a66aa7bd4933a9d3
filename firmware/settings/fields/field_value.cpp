#include "firmware/settings/fields/field_value.h"

#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>

#include "dsp/base/parse_number.h"
#include "firmware/settings/fields/network_text.h"
#include "firmware/settings/text/utf8.h"

namespace stof::settings {
namespace {

bool set_in_range(const Field& field, std::optional<int> value, Settings& settings) noexcept {
  if (!value || *value < field.low || *value > field.high) {
    return false;
  }
  field.set_number(*value, settings);
  return true;
}

bool set_choice(const Field& field, std::string_view text, Settings& settings) noexcept {
  const auto found = std::ranges::find(field.values, text);
  if (found == field.values.end()) {
    return false;
  }
  field.set_number(static_cast<int>(found - field.values.begin()), settings);
  return true;
}

bool set_text(const Field& field, std::string_view text, Settings& settings) noexcept {
  constexpr std::string_view kFolder = "/dev/";
  const auto bytes = static_cast<int>(text.size());
  if (bytes < field.low || bytes > field.high || !plain_utf8(text)) {
    return false;
  }
  if (field.kind == Kind::kDevice && !text.empty() &&
      (!text.starts_with(kFolder) || text.size() == kFolder.size() ||
       text.find("..") != std::string_view::npos)) {
    return false;
  }
  field.set_text(text, settings);
  return true;
}

// Empty where it may be.
bool set_network_text(const Field& field, std::string_view text, Settings& settings) noexcept {
  const bool good = (text.empty() && field.low == 0) ||
                    (field.kind == Kind::kInterface && parse_interface_address(text)) ||
                    (field.kind == Kind::kIpv4 && parse_ipv4(text)) ||
                    (field.kind == Kind::kHostname && is_hostname(text));
  if (good) {
    field.set_text(text, settings);
  }
  return good;
}

// Numbers are kept as they are written out again: 7, never 007.
bool set_match(const Field& field, const Value& value, Settings& settings) noexcept {
  auto& to = settings.depth.match[field.slot];
  if (value.text == kAsPreset) {
    to = {};
    return true;
  }
  std::string_view text = value.text;
  if (value.written != Written::kString && (text == "true" || text == "false")) {
    text = text == "true" ? "on" : "off";
  }
  std::array<char, 12> digits{};
  if (const std::optional<int> number = dsp::parse_number<int>(text)) {
    const char* const end =
        std::to_chars(digits.data(), digits.data() + digits.size(), *number).ptr;
    text = {digits.data(), static_cast<std::size_t>(end - digits.data())};
  }
  dsp::MatchParams unused;
  if (text.size() > kMatchBytes || !field.option->set(text, unused)) {
    return false;
  }
  to = std::remove_reference_t<decltype(to)>(text);
  return true;
}

}  // namespace

bool assign(const Field& field, const Value& value, Settings& settings) noexcept {
  const Written written = value.written;
  const bool bare = written == Written::kBare;
  switch (field.kind) {
    case Kind::kInteger:
      return (bare || written == Written::kNumber) &&
             set_in_range(field, dsp::parse_number<int>(value.text), settings);
    case Kind::kBoolean: {
      const bool yes = value.text == "true";
      return (bare || written == Written::kBoolean) && (yes || value.text == "false") &&
             set_in_range(field, yes ? 1 : 0, settings);
    }
    case Kind::kChoice:
      return (bare || written == Written::kString) && set_choice(field, value.text, settings);
    case Kind::kText:
    case Kind::kDevice:
      return (bare || written == Written::kString) && set_text(field, value.text, settings);
    case Kind::kInterface:
    case Kind::kIpv4:
    case Kind::kHostname:
      return (bare || written == Written::kString) && set_network_text(field, value.text, settings);
    case Kind::kMatch:
      return (bare || written == Written::kString || written == Written::kNumber ||
              written == Written::kBoolean) &&
             set_match(field, value, settings);
  }
  return false;
}

void write_takes(const Field& field, PagedWriter& out) noexcept {
  switch (field.kind) {
    case Kind::kInteger:
      out << field.low << " to " << field.high;
      break;
    case Kind::kBoolean:
      out << "true or false";
      break;
    case Kind::kChoice:
      for (std::size_t k = 0; k < field.values.size(); ++k) {
        if (k > 0) {
          out << (k + 1 == field.values.size() ? " or " : ", ");
        }
        out << field.values[k];
      }
      break;
    case Kind::kText:
      out << field.low << " to " << field.high << " bytes of text without quotes and backslashes";
      break;
    case Kind::kDevice:
      out << "a name below /dev/ of at most " << field.high << " bytes, or nothing";
      break;
    case Kind::kInterface:
      out << "an address of a host with the bits of its network, such as 192.168.7.2/24 (8 to 30 "
             "bits), or nothing";
      break;
    case Kind::kIpv4:
      out << "an address such as 192.168.7.1, or nothing";
      break;
    case Kind::kHostname:
      out << "1 to " << field.high << " small letters, digits and hyphens, no hyphen at the ends";
      break;
    case Kind::kMatch:
      out << field.option->values << ", or " << kAsPreset;
      break;
  }
}

void write_value(const Field& field, const Settings& settings, PagedWriter& out) noexcept {
  switch (field.kind) {
    case Kind::kInteger:
      out << field.number(settings);
      break;
    case Kind::kBoolean:
      out << (field.number(settings) != 0 ? "true" : "false");
      break;
    case Kind::kChoice:
      out << '"' << field.values[static_cast<std::size_t>(field.number(settings))] << '"';
      break;
    case Kind::kText:
    case Kind::kDevice:
    case Kind::kInterface:
    case Kind::kIpv4:
    case Kind::kHostname:
      out << '"' << field.text(settings) << '"';
      break;
    case Kind::kMatch: {
      const std::string_view text = settings.depth.match[field.slot].view();
      if (dsp::parse_number<int>(text)) {
        out << text;
      } else {
        out << '"' << (text.empty() ? kAsPreset : text) << '"';
      }
      break;
    }
  }
}

bool equal(const Field& field, const Settings& a, const Settings& b) noexcept {
  if (field.kind == Kind::kMatch) {
    return a.depth.match[field.slot] == b.depth.match[field.slot];
  }
  return field.text != nullptr ? field.text(a) == field.text(b)
                               : field.number(a) == field.number(b);
}

void copy_field(const Field& field, const Settings& from, Settings& to) noexcept {
  if (field.kind == Kind::kMatch) {
    to.depth.match[field.slot] = from.depth.match[field.slot];
  } else if (field.text != nullptr) {
    field.set_text(field.text(from), to);
  } else {
    field.set_number(field.number(from), to);
  }
}

}  // namespace stof::settings

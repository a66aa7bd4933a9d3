#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "host/lib/json_text.h"
#include "host/lib/sensor.h"

using namespace stof;

namespace {

constexpr std::size_t kAnswerBytes = 65'536;

bool is_path(const char* path) noexcept {
  if (path == nullptr) {
    return false;
  }
  const std::string_view text = path;
  return !text.empty() && text.size() < 128 && text.front() != '.' && text.back() != '.' &&
         text.find("..") == std::string_view::npos &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.-") ==
             std::string_view::npos;
}

// What JSON of a sensor holds without an escape, which it does not take.
bool is_text(const char* value) noexcept {
  const std::string_view text = value == nullptr ? "\"" : value;
  return text.size() < 512 && std::ranges::none_of(
                                  text,
                                  [](char letter) {
                                    return static_cast<unsigned char>(letter) < ' ' ||
                                           letter == '"' || letter == '\\';
                                  });
}

stof_status refuse(std::string_view what, char* why, std::size_t why_size) noexcept {
  lib::give_text(what, why, why_size);
  return STOF_BAD_ARGUMENT;
}

stof_status read_document(stof_sensor* sensor, stof_document document, std::string& text, char* why,
                          std::size_t why_size) {
  text.resize(kAnswerBytes);
  const stof_status status =
      stof_settings(sensor, STOF_GET, document, nullptr, text.data(), text.size(), nullptr);
  text.resize(std::strlen(text.c_str()));
  lib::give_text(status == STOF_OK ? "" : text, why, why_size);
  return status;
}

std::int64_t number_of(std::string_view text, std::int64_t otherwise = 0) noexcept {
  std::int64_t value = otherwise;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::string choices_of(std::string_view items) {
  std::string all;
  while (const auto item = lib::json_next(items)) {
    all += (all.empty() ? "" : " ") + std::string(lib::json_string(*item));
  }
  return all;
}

std::int64_t place_of_choice(std::string_view choice, std::string_view all) noexcept {
  for (std::int64_t place = 0; !all.empty(); ++place) {
    const std::size_t end = std::min(all.find(' '), all.size());
    if (all.substr(0, end) == choice) {
      return place;
    }
    all.remove_prefix(std::min(end + 1, all.size()));
  }
  return -1;  // of no choice that it names
}

// One setting of the schema, with its value.
stof_setting to_setting(std::string_view schema, std::string_view value) {
  const auto text_of = [&](std::string_view name) {
    return lib::json_string(lib::json_member(schema, name).value_or(""));
  };
  stof_setting out{};
  const std::string_view type = text_of("type");
  const std::string_view items = lib::json_member(schema, "enum").value_or("");
  const std::string choices = choices_of(items);
  const auto number = [&](std::string_view text) -> std::int64_t {
    switch (out.kind) {
      case STOF_SETTING_INTEGER:
        return number_of(text);
      case STOF_SETTING_BOOLEAN:
        return text == "true" ? 1 : 0;
      case STOF_SETTING_CHOICE:
        return place_of_choice(text, choices);
      default:
        return 0;
    }
  };
  if (type == "integer") {
    out.kind = STOF_SETTING_INTEGER;
    out.minimum = number_of(text_of("minimum"));
    out.maximum = number_of(text_of("maximum"));
  } else if (type == "boolean") {
    out.kind = STOF_SETTING_BOOLEAN;
    out.maximum = 1;
  } else if (!choices.empty()) {
    out.kind = STOF_SETTING_CHOICE;
    out.maximum = static_cast<std::int64_t>(std::ranges::count(choices, ' '));
  } else {
    out.kind = STOF_SETTING_TEXT;
    out.minimum = number_of(text_of("minLength"));
    out.maximum = number_of(text_of("maxLength"));
  }
  out.value = number(lib::json_string(value));
  out.default_value = number(text_of("default"));
  out.at_restart = text_of("x-applies") == "restart" ? 1 : 0;
  lib::give_text(lib::json_string(value), out.text, sizeof out.text);
  lib::give_text(text_of("x-unit"), out.unit, sizeof out.unit);
  lib::give_text(choices, out.choices, sizeof out.choices);
  return out;
}

// `value` is JSON.
stof_status change(stof_sensor* sensor, const char* path, std::string_view value, char* why,
                   std::size_t why_size) {
  if (sensor == nullptr || !is_path(path)) {
    return refuse("no setting has such a path", why, why_size);
  }
  return lib::guarded([&] {
    std::string json(value);
    std::string_view rest = path;
    while (true) {
      const std::size_t dot = rest.rfind('.');
      const std::string_view name = dot == std::string_view::npos ? rest : rest.substr(dot + 1);
      std::string group = "{\"";
      group.append(name).append("\": ").append(json).append("}");
      json = std::move(group);
      if (dot == std::string_view::npos) {
        break;
      }
      rest = rest.substr(0, dot);
    }
    return stof_settings(sensor, STOF_SET, STOF_ACTIVE, json.c_str(), why, why_size, nullptr);
  });
}

}  // namespace

extern "C" {

stof_status stof_get_setting(stof_sensor* sensor, const char* path, stof_setting* setting,
                             char* why, size_t why_size) {
  lib::give_text("", why, why_size);
  if (sensor == nullptr || setting == nullptr ||
      setting->struct_size < sizeof setting->struct_size || !is_path(path)) {
    return refuse("no setting has such a path", why, why_size);
  }
  return lib::guarded([&] {
    std::string schema;
    {
      const std::scoped_lock lock(sensor->control_mutex);
      schema = sensor->schema;
    }
    if (!lib::json_at(schema, path, "properties")) {  // not asked for yet, or of another version
      if (const stof_status status = read_document(sensor, STOF_SCHEMA, schema, why, why_size);
          status != STOF_OK) {
        return status;
      }
      const std::scoped_lock lock(sensor->control_mutex);
      sensor->schema = schema;
    }
    std::string active;
    if (const stof_status status = read_document(sensor, STOF_ACTIVE, active, why, why_size);
        status != STOF_OK) {
      return status;
    }
    const auto takes = lib::json_at(schema, path, "properties");
    const auto value = lib::json_at(active, path);
    if (!takes || !value || value->front() == '{') {
      return refuse(std::string(path) + ": the sensor has no such setting", why, why_size);
    }
    static_cast<void>(lib::give(setting, to_setting(*takes, *value)));
    return STOF_OK;
  });
}

stof_status stof_set_integer(stof_sensor* sensor, const char* path, int64_t value, char* why,
                             size_t why_size) {
  return lib::guarded([&] { return change(sensor, path, std::to_string(value), why, why_size); });
}

stof_status stof_set_boolean(stof_sensor* sensor, const char* path, int value, char* why,
                             size_t why_size) {
  return change(sensor, path, value != 0 ? "true" : "false", why, why_size);
}

stof_status stof_set_text(stof_sensor* sensor, const char* path, const char* value, char* why,
                          size_t why_size) {
  if (!is_text(value)) {
    return refuse("a text has no quotation mark, backslash or control character", why, why_size);
  }
  return lib::guarded(
      [&] { return change(sensor, path, "\"" + std::string(value) + "\"", why, why_size); });
}

}  // extern "C"

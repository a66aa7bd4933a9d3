#include <algorithm>
#include <array>
#include <expected>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/pair.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/client/control/user_keys.h"
#include "host/client/printable.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// Drops the user's keys that fit; how many.
template <typename Fits>
std::expected<std::size_t, client::OpenError> forget(const std::string& file, Fits&& fits) {
  std::size_t dropped = 0;
  const auto updated = client::update_user_keys(
      file, [&](const wire::KeyTable& keys) -> std::expected<wire::KeyTable, client::OpenError> {
        wire::KeyTable kept;
        for (const wire::Key& key : keys.all()) {
          if (!fits(key)) {
            static_cast<void>(kept.add(key));
          }
        }
        dropped = keys.count() - kept.count();
        return kept;
      });
  if (!updated) {
    return std::unexpected(updated.error());
  }
  return dropped;
}

// The answer, if it is no refusal.
client::ControlAnswer done(client::ControlAnswer answer, const std::string& place) {
  if (answer.result == wire::SettingsResult::kOk) {
    return answer;
  }
  if (answer.result == wire::SettingsResult::kUnknownKey) {
    answer.text = answer.text.empty() ? "has none of your keys" : answer.text;
  }
  throw Failure(
      answer.result == wire::SettingsResult::kInvalid ? Exit::kBadInput : Exit::kFailure,
      place + ": " +
          (answer.text.empty() ? "does not know this request: update the sensor" : answer.text));
}

client::ControlAnswer ask(client::ControlClient& client, wire::SettingsOperation operation,
                          const std::string& text, const std::string& place) {
  return done(value_or_end(client.request(operation, {}, text)), place);
}

// The newest of this user's keys that the sensor has; its id.
std::string end_own(client::ControlClient& client, const std::vector<wire::Key>& own,
                    const std::string& place) {
  for (const wire::Key& key : own) {
    const auto answer =
        value_or_end(client.request(wire::SettingsOperation::kUnpair, {}, id_text(key)));
    if (answer.result != wire::SettingsResult::kInvalid || &key == &own.back()) {
      static_cast<void>(done(answer, place));
      return id_text(key);
    }
  }
  return {};
}

// What a sensor says of its keys; none: it is no list of them.
std::optional<nlohmann::ordered_json> key_list(const std::string& text) {
  auto keys = nlohmann::ordered_json::parse(text, nullptr, false);
  const auto is_key = [](const nlohmann::ordered_json& key) {
    return key.is_object() &&
           std::ranges::all_of(std::array{"id", "role", "name"}, [&key](const char* member) {
             return key.contains(member) && key[member].is_string();
           });
  };
  if (!keys.is_array() || !std::ranges::all_of(keys, is_key)) {
    return std::nullopt;
  }
  return keys;
}

// A line each; those that are in the user's file are marked.
std::string key_table(const nlohmann::ordered_json& keys, const wire::KeyTable& own) {
  if (keys.empty()) {
    return "there is no key\n";
  }
  constexpr const char* kRow = "%-8s  %-5s  %-5s  %s\n";
  std::string text = printed(kRow, "key", "role", "yours", "name");
  for (const auto& key : keys) {
    const std::string id = key["id"];
    const bool yours =
        std::ranges::any_of(own.all(), [&id](const wire::Key& one) { return id_text(one) == id; });
    text += printed(kRow, id.c_str(), key["role"].get<std::string>().c_str(), yours ? "yes" : "",
                    key["name"].get<std::string>().c_str());
  }
  return text;
}

void list_keys(client::ControlClient& client, const wire::KeyTable& own, const std::string& place,
               bool json) {
  const auto answer = ask(client, wire::SettingsOperation::kKeys, {}, place);
  const auto keys = key_list(answer.text);
  if (!keys) {
    throw Failure(Exit::kFailure,
                  place + ": answers with what is no list of keys: update the sensor");
  }
  if (json) {
    say_json(*keys);
  } else {
    say_text(client::printable(key_table(*keys, own), client::Lines::kSeveral));
  }
}

// In this user's file alone.
void forget_only(const UnpairOptions& options, const std::string& file, std::uint32_t device,
                 std::uint32_t key_id) {
  const std::uint32_t named = key_id_of(options.id, "--id");
  const std::size_t count = value_or_fail(forget(file, [&](const wire::Key& key) {
    return key.device == device && (key_id == 0 || key.id == key_id) &&
           (named == 0 || key.id == named);
  }));
  if (count == 0) {
    throw Failure(
        Exit::kBadInput,
        file + printed(": has no such key of sensor %08x: nothing was forgotten", device));
  }
  if (options.json) {
    say_json({{"forgotten", count}, {"device_id", device}, {"file", file}});
  } else {
    say(printed("%zu keys of sensor %08x forgotten in %s", count, device, file.c_str()));
  }
}

}  // namespace

void unpair(const UnpairOptions& options) {
  need_crypto();
  const std::string file = keys_file(options.keys);
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(file));
  const std::uint32_t key_id = key_id_of(options.key);
  static_cast<void>(key_id_of(options.id, "--id"));  // before anything is asked
  const bool named = options.forget && options.device;
  const bool any = !options.serial.empty() && (options.list || !options.id.empty());
  const client::Meant meant =
      key_id == 0 && (any || named)
          ? client::Meant{.device = options.device, .keys = keys}
          : meant_or_fail(file, keys, options.sensor, {.device = options.device, .key_id = key_id});
  const std::uint32_t device = device_of(meant);
  if (options.forget) {
    forget_only(options, file, device, key_id);
    return;
  }
  if (options.list && options.serial.empty() && meant.keys.count() == 0) {
    throw Failure(Exit::kBadInput, file + ": has no key of " + options.sensor +
                                       ": pair with it first: stof pair " + options.sensor);
  }
  auto transport = open_way("unpair", options.sensor, options.serial, options.baud);
  const std::string place = transport->place();
  client::ControlOptions control = timing(options.timeout_s);
  control.keys = meant.keys;
  control.device_id = meant.device ? meant.device : found_device(options.sensor);
  control.unsigned_answers =
      options.serial.empty() ? client::Unsigned::kNever : client::Unsigned::kAlways;
  client::ControlClient client(std::move(transport), control);
  check_called(client, options.sensor);
  if (options.list) {
    list_keys(client, keys, place, options.json);
    return;
  }
  const std::string id =
      options.id.empty() ? end_own(client, own_keys(file, meant.keys, device), place) : options.id;
  if (!options.id.empty()) {
    static_cast<void>(ask(client, wire::SettingsOperation::kUnpair, id, place));
  }
  if (client.proven() && !options.sensor.empty()) {
    remember_place(file, {.named = options.sensor, .address = place}, client.proven()->key_id);
  }
  value_or_end(forget(file, [&id](const wire::Key& key) { return id == id_text(key); }));
  const std::uint32_t proven = client.proven() ? client.proven()->device : device;
  if (options.json) {
    say_json({{"ended", client::printable(id)}, {"device_id", proven}, {"file", file}});
  } else {
    say(printed("key %s of sensor %08x is none any more", client::printable(id).c_str(), proven));
  }
}

}  // namespace stof::host

#include "host/cli/pair.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <memory>

#include <unistd.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/key_text.h"
#include "host/cli/failure.h"
#include "host/cli/serial_transport.h"
#include "host/client/control/pair_client.h"
#include "host/client/control/user_keys.h"
#include "host/client/printable.h"

namespace stof::host {
namespace {

std::string user_and_host() {
  const char* const user = std::getenv("USER");  // NOLINT(concurrency-mt-unsafe): nobody sets one
  std::array<char, 64> host{};
  static_cast<void>(::gethostname(host.data(), host.size() - 1));
  return std::string(user == nullptr ? "user" : user) + "@" + host.data();
}

void need_crypto() {
  if (!wire::start_crypto()) {
    throw Failure(Exit::kFailure, "pair: this system has no random numbers");
  }
}

std::string own_name(const PairOptions& options) {
  return options.name.empty() ? user_and_host() : options.name;
}

wire::Key random_key(const PairOptions& options) {
  std::array<std::byte, 4> id{};
  wire::fill_random(id);
  wire::Key key{.id = std::max(wire::get_u32(id), 1U),
                .device = options.device,
                .role = wire::role_of(options.role),
                .name = wire::key_name(own_name(options))};
  wire::fill_random(key.secret);
  return key;
}

// Whether both files have a key in common already.
bool paired(const wire::KeyTable& sensor, const wire::KeyTable& user, std::uint32_t device) {
  return std::ranges::any_of(user.all(), [&](const wire::Key& key) {
    const wire::Key* const same = sensor.find(key.id);
    return key.device == device && same != nullptr && same->role == key.role &&
           wire::equal_secrets(same->secret, key.secret);
  });
}

client::ControlOptions timing(double timeout_s) {
  return {.timeout = std::chrono::duration_cast<client::Duration>(
              std::chrono::duration<double>(timeout_s))};
}

std::unique_ptr<client::ControlTransport> open(const char* command, const std::string& sensor,
                                               const std::string& serial, unsigned baud) {
  if (sensor.empty() == serial.empty()) {
    throw Failure(Exit::kBadInput,
                  std::string(command) + ": give a sensor, HOST[:PORT], or --serial");
  }
  return sensor.empty() ? value_or_fail(open_serial_transport(serial, baud))
                        : value_or_fail(client::open_udp_transport(sensor));
}

template <typename Expected>
auto value_or_end(Expected&& result) {
  if (!result) {
    throw Failure(Exit::kFailure, result.error().message);
  }
  if constexpr (!std::is_void_v<typename std::remove_cvref_t<Expected>::value_type>) {
    return std::move(*std::forward<Expected>(result));
  }
}

// Digits alone of what somebody typed.
std::string digits_in(const std::string& text) {
  std::string digits;
  for (const char c : text) {
    if (c >= '0' && c <= '9') {
      digits += c;
    } else if (c != ' ') {
      return {};
    }
  }
  return digits;
}

// The user types what the sensor tells: who only has to say yes says it too soon.
void compare_digits(std::uint32_t ours, const PairOptions& options) {
  std::string told = options.digits;
  if (told.empty()) {
    std::printf("Type the six digits that the sensor tells (its log, its serial line): ");
    std::fflush(stdout);
    std::getline(std::cin, told);
  }
  const std::string wanted = std::to_string(1'000'000 + ours).substr(1);
  if (digits_in(told) != wanted) {
    throw Failure(Exit::kFailure, "pair: the digits here are " + wanted +
                                      ": another, so somebody is between you. Nothing was paired");
  }
}

// The newest key of a sensor whose number only the sensor knows.
wire::Key own_key(const std::string& file, std::uint32_t device) {
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(file));
  for (std::size_t i = keys.count(); i-- > 0;) {
    if (keys.all()[i].device == device) {
      return keys.all()[i];
    }
  }
  throw Failure(Exit::kFailure, file + ": has no key of this sensor (" + std::to_string(device) +
                                    "): pair, or name its number with --device");
}

client::PairWish wish_of(const PairOptions& options, const std::string& file) {
  client::PairWish wish{.role = wire::role_of(options.role), .name = own_name(options)};
  if (options.renew) {
    const wire::Key key = own_key(file, options.device);
    wish.method = wire::PairMethod::kKey;
    wish.role = key.role;
    wish.name = key.name_text();
    wish.known.assign(key.secret.begin(), key.secret.end());
    wish.key_id = key.id;
  } else if (!options.code.empty()) {
    const auto code = wire::code_of(options.code);
    if (!code) {
      throw Failure(Exit::kBadInput, "--code: takes the 32 hexadecimal digits of the label");
    }
    wish.method = wire::PairMethod::kCode;
    wish.known.assign(code->begin(), code->end());
  } else if (!options.serial.empty()) {
    wish.method = wire::PairMethod::kCable;
  }
  return wish;
}

void pair_with(const PairOptions& options, const std::string& file) {
  auto transport = open("pair", options.sensor, options.serial, options.baud);
  const client::PairWish wish = wish_of(options, file);
  client::ControlOptions control = timing(options.timeout_s);
  if (options.renew) {
    control.device_id = options.device;
  }
  // Whether it can be kept, before the sensor has it.
  value_or_fail(client::write_user_keys(file, value_or_fail(client::read_user_keys(file))));
  client::PairClient client(std::move(transport), wish, control);
  value_or_end(client.start());
  if (wish.method == wire::PairMethod::kDigits) {
    compare_digits(client.digits(), options);
    std::printf("They are equal. Now accept them at the sensor: hold its button for 3 seconds.\n");
    std::fflush(stdout);
  }
  const wire::Key key = value_or_end(client.finish(std::chrono::minutes(2)));
  value_or_fail(client::add_user_key(file, key));
  std::printf("key %08x of sensor %08x, %s, is in %s\n", key.id, key.device,
              std::string(wire::role_text(key.role)).c_str(), file.c_str());
}

void pair_into(const PairOptions& options, const std::string& own) {
  wire::KeyTable sensor = value_or_fail(client::read_user_keys(options.into));
  if (paired(sensor, value_or_fail(client::read_user_keys(own)), options.device)) {
    std::printf("%s: has a key of %s already\n", options.into.c_str(), own.c_str());
    return;
  }
  const wire::Key key = random_key(options);
  if (sensor.add(key) != Status::kOk) {
    throw Failure(Exit::kFailure, options.into + ": takes no more keys");
  }
  value_or_fail(client::write_user_keys(options.into, sensor));
  value_or_fail(client::add_user_key(own, key));
  std::printf("key %08x, %s, is in %s and in %s\n", key.id, options.role.c_str(),
              options.into.c_str(), own.c_str());
}

// Drops the user's keys that fit; how many.
template <typename Fits>
std::size_t forget(const std::string& file, Fits&& fits) {
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(file));
  wire::KeyTable kept;
  for (const wire::Key& key : keys.all()) {
    if (!fits(key)) {
      static_cast<void>(kept.add(key));
    }
  }
  if (kept.count() < keys.count()) {
    value_or_fail(client::write_user_keys(file, kept));
  }
  return keys.count() - kept.count();
}

client::ControlAnswer ask(client::ControlClient& client, wire::SettingsOperation operation,
                          const std::string& text, const std::string& place) {
  client::ControlAnswer answer = value_or_end(client.request(operation, {}, text));
  if (answer.result == wire::SettingsResult::kOk) {
    return answer;
  }
  if (answer.result == wire::SettingsResult::kUnknownKey) {
    answer.text = "has none of your keys any more";
  }
  throw Failure(
      answer.result == wire::SettingsResult::kInvalid ? Exit::kBadInput : Exit::kFailure,
      place + ": " +
          (answer.text.empty() ? "does not know this request: update the sensor" : answer.text));
}

}  // namespace

std::string keys_file(const std::string& named) {
  return named.empty() ? client::user_keys_file() : named;
}

void pair(const PairOptions& options) {
  need_crypto();
  const std::string own = keys_file(options.keys);
  if (options.into.empty()) {
    pair_with(options, own);
  } else {
    pair_into(options, own);
  }
}

void unpair(const UnpairOptions& options) {
  need_crypto();
  const std::string file = keys_file(options.keys);
  if (options.forget) {
    const std::size_t count =
        forget(file, [&options](const wire::Key& key) { return key.device == options.device; });
    std::printf("%zu keys of sensor %08x forgotten in %s\n", count, options.device, file.c_str());
    return;
  }
  auto transport = open("unpair", options.sensor, options.serial, options.baud);
  const std::string place = transport->place();
  std::string id = options.id;
  if (id.empty() && !options.list) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", own_key(file, options.device).id);
    id = text.data();
  }
  client::ControlOptions control = timing(options.timeout_s);
  control.keys = value_or_fail(client::read_user_keys(file));
  client::ControlClient client(std::move(transport), control);
  if (options.list) {
    const auto answer = ask(client, wire::SettingsOperation::kKeys, {}, place);
    std::printf("%s\n", client::printable(answer.text, client::Lines::kSeveral).c_str());
    return;
  }
  static_cast<void>(ask(client, wire::SettingsOperation::kUnpair, id, place));
  static_cast<void>(forget(file, [&id](const wire::Key& key) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", key.id);
    return id == text.data();
  }));
  std::printf("key %s is none any more\n", client::printable(id).c_str());
}

void add_pair(CLI::App& app, PairOptions& options, UnpairOptions& unpairing) {
  const auto add_line = [](CLI::App& command, auto& into) {
    command.add_option("SENSOR", into.sensor, "HOST[:PORT], none with --serial");
    command.add_option("--serial", into.serial, "Serial line to the sensor, such as /dev/ttyUSB0");
    command.add_option("--baud", into.baud, "Its speed, bit/s")
        ->check(CLI::Range(57'600U, 12'000'000U))
        ->capture_default_str();
    command.add_option("--device", into.device, "Number of the sensor (stofd --device)")
        ->capture_default_str();
    command.add_option("--keys", into.keys,
                       "Your key file (default: ~/.config/stof/keys, or as XDG_CONFIG_HOME says)");
    command.add_option("--timeout", into.timeout_s, "Seconds to wait for each of three attempts")
        ->check(CLI::Range(0.01, 60.0))
        ->capture_default_str();
  };
  CLI::App& command = *app.add_subcommand(
      "pair", "Make a key that a sensor and you share: press its button first, or use its cable");
  add_line(command, options);
  command.add_option("--code", options.code,
                     "32 hexadecimal digits of its label: nothing is asked");
  command.add_flag("--renew", options.renew, "Give the key that you have of it a new secret");
  command.add_option("--digits", options.digits, "That the sensor told, in place of being asked");
  command.add_option("--into", options.into,
                     "Key file of a sensor that does not run: gets the key (stofd --keys)");
  command.add_option("--role", options.role, "What the key may: view, tune or admin")
      ->check(CLI::IsMember({"view", "tune", "admin"}))
      ->capture_default_str();
  command.add_option("--name", options.name, "Whose it is (default: user@host)");
  command.callback([&options] { pair(options); });

  CLI::App& ending = *app.add_subcommand("unpair", "End a key of a sensor, or list them");
  add_line(ending, unpairing);
  ending.add_option("--id", unpairing.id, "Of the key, 8 digits (default: your own)");
  ending.add_flag("--list", unpairing.list, "Print which keys there are");
  ending.add_flag("--forget", unpairing.forget, "Only in your file: the sensor --device is gone");
  ending.callback([&unpairing] { unpair(unpairing); });
}

}  // namespace stof::host

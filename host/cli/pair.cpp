#include "host/cli/pair.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
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
                .device = options.device.value_or(1),
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

// The code itself, `@FILE`, or `-` for standard input: a command line is for all users to read.
std::string named_code(const std::string& named) {
  if (named != "-" && !named.starts_with('@')) {
    return named;
  }
  std::ifstream file;
  if (named != "-") {
    file.open(named.substr(1));
    if (!file) {
      throw Failure(Exit::kBadInput, named.substr(1) + ": cannot be read: --code takes @FILE");
    }
  }
  constexpr std::size_t kLine = 128;
  std::array<char, kLine> space{};
  (named == "-" ? std::cin : file).getline(space.data(), space.size());
  return space.data();
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

// Of a sensor, the newest first. Two sensors may have one number.
std::vector<wire::Key> own_keys(const std::string& file, const wire::KeyTable& keys,
                                std::uint32_t device) {
  std::vector<wire::Key> own;
  for (std::size_t i = keys.count(); i-- > 0;) {
    if (keys.all()[i].device == device) {
      own.push_back(keys.all()[i]);
    }
  }
  if (own.empty()) {
    throw Failure(Exit::kFailure, file + ": has no key of this sensor (" + std::to_string(device) +
                                      "): pair, or name its number with --device");
  }
  return own;
}

// Throws Failure where nobody knows which of several sensors is meant.
client::Meant meant_or_fail(const std::string& file, const wire::KeyTable& keys,
                            const std::string& sensor, std::optional<std::uint32_t> asked) {
  client::Meant meant = value_or_fail(client::meant_sensor(file, keys, sensor, asked));
  if (!meant.doubt.empty()) {
    throw Failure(Exit::kBadInput,
                  (sensor.empty() ? file : sensor) + ": " + meant.doubt + " (--device NUMBER)");
  }
  return meant;
}

// Else the only one.
std::uint32_t device_of(const client::Meant& meant) {
  return meant.device.value_or(meant.keys.count() == 0 ? 1 : meant.keys.all()[0].device);
}

// Where the new secret of a key is kept until the sensor has taken it for sure: whatever happens
// between, either this one or that of before opens the sensor.
std::string renewed_file(const std::string& file) { return file + ".renewed"; }

client::PairWish renewal_of(const wire::Key& key) {
  client::PairWish wish{
      .method = wire::PairMethod::kKey, .role = key.role, .name = std::string(key.name_text())};
  wish.known.assign(key.secret.begin(), key.secret.end());
  wish.key_id = key.id;
  return wish;
}

client::PairWish wish_of(const PairOptions& options) {
  client::PairWish wish{.role = wire::role_of(options.role), .name = own_name(options)};
  if (!options.code.empty()) {
    const auto code = wire::code_of(named_code(options.code));
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

// Whether a key could be kept in it, before the sensor has one.
void need_room(const std::string& file) {
  value_or_fail(client::update_user_keys(file, [](const wire::KeyTable& keys) {
    return std::expected<wire::KeyTable, client::OpenError>(keys);
  }));
}

void say_kept(const wire::Key& key, const std::string& file) {
  std::printf("key %08x of sensor %08x, %s, is in %s\n", key.id, key.device,
              std::string(wire::role_text(key.role)).c_str(), file.c_str());
}

// The sensor drops the secret of before when it has seen the new one.
bool opens(const PairOptions& options, const wire::Key& key) {
  client::ControlOptions control = timing(options.timeout_s);
  control.device_id = key.device;
  control.unsigned_answers = client::Unsigned::kNever;
  static_cast<void>(control.keys.add(key));
  client::ControlClient client(open("pair", options.sensor, options.serial, options.baud), control);
  const auto answer = client.request(wire::SettingsOperation::kKeys, {}, {});
  return answer && answer->result != wire::SettingsResult::kUnknownKey;
}

void renew(const PairOptions& options, const std::string& file) {
  const std::string waiting = renewed_file(file);
  need_room(file);
  const client::Meant meant = meant_or_fail(file, value_or_fail(client::read_user_keys(file)),
                                            options.sensor, options.device);
  const std::uint32_t device = device_of(meant);
  std::vector<wire::Key> known = own_keys(file, meant.keys, device);
  const wire::KeyTable before = value_or_fail(client::read_user_keys(waiting));
  known.insert(known.end(), before.all().begin(), before.all().end());
  client::ControlOptions control = timing(options.timeout_s);
  control.device_id = device;
  std::string refusal;
  for (const wire::Key& key : known) {
    client::PairClient client(open("pair", options.sensor, options.serial, options.baud),
                              renewal_of(key), control);
    if (const auto started = client.start(); !started) {
      refusal = refusal.empty() ? started.error().message : refusal;
      continue;
    }
    const wire::Key next = client.key();
    wire::KeyTable kept;
    static_cast<void>(kept.add(next));
    value_or_fail(client::write_user_keys(waiting, kept));
    const auto finished = client.finish(std::chrono::seconds(2));
    if (!finished && !opens(options, next)) {
      throw Failure(Exit::kFailure, finished.error().message);
    }
    value_or_fail(client::add_user_key(file, next));
    if (finished && !opens(options, next)) {
      throw Failure(Exit::kFailure, file +
                                        ": has the new secret, but the sensor does not answer: "
                                        "try again with --renew");
    }
    static_cast<void>(std::remove(waiting.c_str()));
    say_kept(next, file);
    return;
  }
  throw Failure(Exit::kFailure, refusal);
}

// What else opens a sensor of this number.
void say_older(const wire::KeyTable& keys, const wire::Key& newest) {
  for (const wire::Key& key : keys.all()) {
    if (key.device == newest.device && key.id != newest.id) {
      std::printf(
          "an older key %08x of a sensor with this number stays: if it is of this sensor, end it "
          "by stof unpair SENSOR --id %08x\n",
          key.id, key.id);
    }
  }
}

void pair_with(const PairOptions& options, const std::string& file) {
  auto transport = open("pair", options.sensor, options.serial, options.baud);
  const client::PairWish wish = wish_of(options);
  need_room(file);
  const std::string address = transport->place();
  client::ControlOptions control = timing(options.timeout_s);
  control.device_id = options.device;
  client::PairClient client(std::move(transport), wish, control);
  value_or_end(client.start());
  if (wish.method == wire::PairMethod::kDigits) {
    compare_digits(client.digits(), options);
    std::printf("They are equal. Now accept them at the sensor: hold its button for 3 seconds.\n");
    std::fflush(stdout);
  }
  // Whoever sits between may hold back or forge the last answer: the key itself says whether it is
  // one of the sensor's.
  const auto finished = client.finish(std::chrono::minutes(2));
  const wire::Key key = client.key();
  if (!finished && !opens(options, key)) {
    throw Failure(Exit::kFailure, finished.error().message);
  }
  if (value_or_fail(client::read_user_keys(file)).find(key.id) != nullptr) {
    throw Failure(Exit::kFailure, "sensor " + address +
                                      ": gave the key the number of one that you have: it "
                                      "imitates another sensor, and nothing was kept");
  }
  value_or_fail(client::add_user_key(file, key));
  say_kept(key, file);
  if (!options.sensor.empty()) {
    remember_place(file, {.named = options.sensor, .address = address}, key.id);
  }
  say_older(value_or_fail(client::read_user_keys(file)), key);
}

void pair_into(const PairOptions& options, const std::string& own) {
  wire::KeyTable sensor = value_or_fail(client::read_user_keys(options.into));
  if (paired(sensor, value_or_fail(client::read_user_keys(own)), options.device.value_or(1))) {
    std::printf("%s: has a key of %s already\n", options.into.c_str(), own.c_str());
    return;
  }
  const wire::Key key = random_key(options);
  if (sensor.count() >= wire::kMostSensorKeys || sensor.add(key) != Status::kOk) {
    throw Failure(Exit::kFailure, options.into +
                                      ": a sensor keeps 16 keys: end one of them first "
                                      "(stof unpair)");
  }
  value_or_fail(client::write_user_keys(options.into, sensor));
  value_or_fail(client::add_user_key(own, key));
  std::printf("key %08x, %s, is in %s and in %s\n", key.id, options.role.c_str(),
              options.into.c_str(), own.c_str());
}

// Drops the user's keys that fit; how many.
template <typename Fits>
std::size_t forget(const std::string& file, Fits&& fits) {
  std::size_t dropped = 0;
  value_or_fail(client::update_user_keys(
      file, [&](const wire::KeyTable& keys) -> std::expected<wire::KeyTable, client::OpenError> {
        wire::KeyTable kept;
        for (const wire::Key& key : keys.all()) {
          if (!fits(key)) {
            static_cast<void>(kept.add(key));
          }
        }
        dropped = keys.count() - kept.count();
        return kept;
      }));
  return dropped;
}

std::string id_text(const wire::Key& key) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", key.id);
  return text.data();
}

// The answer, if it is no refusal.
client::ControlAnswer done(client::ControlAnswer answer, const std::string& place) {
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

}  // namespace

void remember_place(const std::string& key_file, const client::Place& place, std::uint32_t key_id) {
  if (const auto keys = client::read_user_keys(key_file)) {
    static_cast<void>(client::remember_sensor(key_file, *keys, place, key_id));
  }
}

std::string keys_file(const std::string& named) {
  return named.empty() ? client::user_keys_file() : named;
}

void pair(const PairOptions& options) {
  need_crypto();
  const std::string own = keys_file(options.keys);
  if (!options.into.empty()) {
    pair_into(options, own);
  } else if (options.renew) {
    renew(options, own);
  } else {
    pair_with(options, own);
  }
}

void unpair(const UnpairOptions& options) {
  need_crypto();
  const std::string file = keys_file(options.keys);
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(file));
  const bool any = !options.serial.empty() && (options.list || !options.id.empty());
  const client::Meant meant = any ? client::Meant{.device = options.device, .keys = keys}
                                  : meant_or_fail(file, keys, options.sensor, options.device);
  const std::uint32_t device = device_of(meant);
  if (options.forget) {
    const std::size_t count =
        forget(file, [device](const wire::Key& key) { return key.device == device; });
    std::printf("%zu keys of sensor %08x forgotten in %s\n", count, device, file.c_str());
    return;
  }
  auto transport = open("unpair", options.sensor, options.serial, options.baud);
  const std::string place = transport->place();
  client::ControlOptions control = timing(options.timeout_s);
  control.keys = meant.keys;
  control.device_id = meant.device;
  control.unsigned_answers =
      options.serial.empty() ? client::Unsigned::kNever : client::Unsigned::kAlways;
  client::ControlClient client(std::move(transport), control);
  if (options.list) {
    const auto answer = ask(client, wire::SettingsOperation::kKeys, {}, place);
    std::printf("%s\n", client::printable(answer.text, client::Lines::kSeveral).c_str());
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
  static_cast<void>(forget(file, [&id](const wire::Key& key) { return id == id_text(key); }));
  std::printf("key %s of sensor %08x is none any more\n", client::printable(id).c_str(),
              client.proven() ? client.proven()->device : device);
}

void add_pair(CLI::App& app, PairOptions& options, UnpairOptions& unpairing) {
  const auto add_line = [](CLI::App& command, auto& into) {
    command.add_option("SENSOR", into.sensor, "HOST[:PORT], none with --serial");
    command.add_option("--serial", into.serial, "Serial line to the sensor, such as /dev/ttyUSB0");
    command.add_option("--baud", into.baud, "Its speed, bit/s")
        ->check(CLI::Range(57'600U, 12'000'000U))
        ->capture_default_str();
    command.add_option("--device", into.device,
                       "Number of the sensor (stofd --device): only it is believed");
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
                     "32 hexadecimal digits of its label: nothing is asked. Better @FILE, or - for "
                     "standard input: a command line is for all users to read");
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

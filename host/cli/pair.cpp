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
#include <thread>

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

std::string six_digits(std::uint32_t digits) {
  return std::to_string(1'000'000 + digits).substr(1);
}

// The user types what the sensor tells: who only has to say yes says it too soon.
void compare_digits(std::uint32_t ours, const PairOptions& options) {
  std::string told = options.digits;
  if (told.empty()) {
    std::printf("Type the six digits that the sensor tells (its log, its serial line): ");
    std::fflush(stdout);
    std::getline(std::cin, told);
  }
  const std::string wanted = six_digits(ours);
  if (digits_in(told) != wanted) {
    throw Failure(Exit::kFailure, "pair: the digits here are " + wanted +
                                      ": another, so somebody is between you. Nothing was paired");
  }
}

// Of a sensor, the newest first. Two sensors may have one number.
std::vector<wire::Key> own_keys(const std::string& file, std::uint32_t device) {
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(file));
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
  std::vector<wire::Key> known = own_keys(file, options.device);
  const wire::KeyTable before = value_or_fail(client::read_user_keys(waiting));
  known.insert(known.end(), before.all().begin(), before.all().end());
  client::ControlOptions control = timing(options.timeout_s);
  control.device_id = options.device;
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
  client::PairClient client(std::move(transport), wish, timing(options.timeout_s));
  value_or_end(client.start());
  if (wish.method == wire::PairMethod::kDigits) {
    compare_digits(client.digits(), options);
    std::printf(
        "They are equal. Now accept them at the sensor: hold its button for 3 seconds, or type "
        "them where stof pair --window asks.\n");
    std::fflush(stdout);
  }
  const wire::Key key = value_or_end(client.finish(std::chrono::minutes(2)));
  value_or_fail(client::add_user_key(file, key));
  say_kept(key, file);
  say_older(value_or_fail(client::read_user_keys(file)), key);
}

// Whoever holds the cable stands for the button. He types the digits once more: who only has to say
// yes says it before the other end has compared them.
std::uint32_t accepted_digits(std::uint32_t told) {
  constexpr std::uint32_t kNone = 1'000'000;
  const std::string wanted = six_digits(told);
  std::printf(
      "The sensor's digits are %s: type them into stof pair. Only if it says that they are equal, "
      "type them here too: ",
      wanted.c_str());
  std::fflush(stdout);
  std::string typed;
  std::getline(std::cin, typed);
  return digits_in(typed) == wanted ? told : kNone;
}

void open_window(const PairOptions& options) {
  if (options.serial.empty()) {
    throw Failure(Exit::kBadInput,
                  "pair: --window takes --serial: over the network nobody opens it");
  }
  client::PairClient client(open("pair", options.sensor, options.serial, options.baud),
                            {.name = own_name(options)}, timing(options.timeout_s));
  client::PairWindow window = value_or_end(client.open_window());
  std::printf("Pairing is open for two minutes: now stof pair SENSOR, where the key shall be.\n");
  std::fflush(stdout);
  for (bool asked = false; window.key_id == 0;) {
    if (window.digits && !asked) {
      asked = true;
      window = value_or_end(client.accept(accepted_digits(*window.digits)));
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      window = value_or_end(client.open_window());
    }
  }
  std::printf("key %08x is in force: whoever ran stof pair has it\n", window.key_id);
}

void pair_into(const PairOptions& options, const std::string& own) {
  wire::KeyTable sensor = value_or_fail(client::read_user_keys(options.into));
  if (paired(sensor, value_or_fail(client::read_user_keys(own)), options.device)) {
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

std::string keys_file(const std::string& named) {
  return named.empty() ? client::user_keys_file() : named;
}

void pair(const PairOptions& options) {
  need_crypto();
  const std::string own = keys_file(options.keys);
  if (!options.into.empty()) {
    pair_into(options, own);
  } else if (options.window) {
    open_window(options);
  } else if (options.renew) {
    renew(options, own);
  } else {
    pair_with(options, own);
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
  client::ControlOptions control = timing(options.timeout_s);
  control.keys = value_or_fail(client::read_user_keys(file));
  control.unsigned_answers =
      options.serial.empty() ? client::Unsigned::kNever : client::Unsigned::kAlways;
  client::ControlClient client(std::move(transport), control);
  if (options.list) {
    const auto answer = ask(client, wire::SettingsOperation::kKeys, {}, place);
    std::printf("%s\n", client::printable(answer.text, client::Lines::kSeveral).c_str());
    return;
  }
  const std::string id =
      options.id.empty() ? end_own(client, own_keys(file, options.device), place) : options.id;
  if (!options.id.empty()) {
    static_cast<void>(ask(client, wire::SettingsOperation::kUnpair, id, place));
  }
  static_cast<void>(forget(file, [&id](const wire::Key& key) { return id == id_text(key); }));
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
                     "32 hexadecimal digits of its label: nothing is asked. Better @FILE, or - for "
                     "standard input: a command line is for all users to read");
  command.add_flag("--renew", options.renew, "Give the key that you have of it a new secret");
  command.add_option("--digits", options.digits, "That the sensor told, in place of being asked");
  command.add_option("--into", options.into,
                     "Key file of a sensor that does not run: gets the key (stofd --keys)");
  command
      .add_flag(
          "--window", options.window,
          "Make no key, but let somebody else: as the sensor's button, for who holds the cable")
      ->excludes("--code", "--renew", "--digits", "--into");
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

#include "host/cli/pair.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <memory>
#include <span>
#include <thread>
#include <utility>

#include <unistd.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/key_text.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/pairing.h"
#include "host/cli/stop_signal.h"
#include "host/client/control/pair_client.h"
#include "host/client/control/user_keys.h"
#include "host/text/printed.h"
#include "posix/socket_address.h"

namespace stof::host {
namespace {

constexpr std::size_t kDigits = 6;

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

// What is asked and said meanwhile: --json leaves stdout to its object.
std::FILE* talk(const PairOptions& options) { return options.json ? stderr : stdout; }

// The user types what the sensor tells: who only has to say yes says it too soon.
void compare_digits(std::uint32_t ours, const PairOptions& options) {
  std::string told = options.digits;
  if (told.empty()) {
    std::fprintf(talk(options),
                 "Type the six digits that the sensor tells (its log, its serial line): ");
    std::fflush(talk(options));
    std::getline(std::cin, told);
  }
  if (asked_to_stop()) {
    throw Failure(Exit::kFailure, "pair: was given up: nothing was paired");
  }
  const std::string typed = digits_in(told);
  if (typed.empty()) {
    throw Failure(Exit::kBadInput,
                  "pair: no digits were given, so nothing was paired: begin again, and type those "
                  "that the sensor tells, or give --digits");
  }
  if (typed != six_digits(ours)) {
    throw Failure(Exit::kFailure, "pair: " + other_digits(typed, ours));
  }
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
    if (!prove_by_code(wish, named_code(options.code))) {
      throw Failure(Exit::kBadInput, "--code: takes the 32 hexadecimal digits of the label");
    }
  } else if (!options.serial.empty()) {
    wish.method = wire::PairMethod::kCable;
  }
  return wish;
}

nlohmann::ordered_json key_json(const wire::Key& key, const std::string& file) {
  return {{"key", id_text(key)},
          {"device_id", key.device},
          {"role", wire::role_text(key.role)},
          {"name", key.name_text()},
          {"file", file}};
}

void say_kept(const PairOptions& options, const wire::Key& key, const std::string& file,
              const std::vector<wire::Key>& older) {
  if (options.json) {
    nlohmann::ordered_json json = key_json(key, file);
    json["older"] = nlohmann::ordered_json::array();
    for (const wire::Key& one : older) {
      json["older"].push_back(id_text(one));
    }
    say_json(json);
    return;
  }
  say(kept_text(key, file));
  for (const wire::Key& one : older) {
    say(printed(
        "an older key %08x of a sensor with this number stays: if it is of this sensor, end it "
        "by stof unpair SENSOR --id %08x",
        one.id, one.id));
  }
}

void renew(const PairOptions& options, const std::string& file) {
  const std::string waiting = renewed_file(file);
  const PairingTerms terms = pairing_terms(options, options.sensor, file);
  need_key_room(file);
  const client::Meant meant =
      meant_or_fail(file, value_or_fail(client::read_user_keys(file)), options.sensor,
                    {.device = options.device, .key_id = key_id_of(options.key)});
  const std::uint32_t device = device_of(meant);
  std::vector<wire::Key> known = own_keys(file, meant.keys, device);
  const wire::KeyTable before = value_or_fail(client::read_user_keys(waiting));
  known.insert(known.end(), before.all().begin(), before.all().end());
  client::ControlOptions control = timing(options.timeout_s);
  control.device_id = device;
  check_called(options.sensor, control, meant.keys);
  std::string refusal;
  for (const wire::Key& key : known) {
    client::PairClient client(open_way("pair", options.sensor, options.serial, options.baud),
                              renewal_of(key), control);
    if (const auto started = client.start(); !started) {
      refusal = refusal.empty() ? started.error().message : refusal;
      continue;
    }
    const wire::Key next = client.key();
    if (next.id != key.id) {
      throw Failure(Exit::kFailure, options.sensor + options.serial +
                                        ": renews another key than it was asked for: it imitates "
                                        "another sensor, and nothing was renewed");
    }
    wire::KeyTable kept;
    static_cast<void>(kept.add(next));
    value_or_end(client::write_user_keys(waiting, kept));
    const auto finished = client.finish(std::chrono::seconds(2));
    if (!finished && !opens_sensor(terms, next)) {
      throw Failure(Exit::kFailure, finished.error().message);
    }
    value_or_end(client::add_user_key(file, next));  // the sensor has it already
    if (finished && !opens_sensor(terms, next)) {
      throw Failure(Exit::kFailure, file +
                                        ": has the new secret, but the sensor does not answer: "
                                        "try again with --renew");
    }
    static_cast<void>(std::remove(waiting.c_str()));
    say_kept(options, next, file, {});
    return;
  }
  throw Failure(Exit::kFailure, refusal);
}

// What else opens a sensor of this number.
std::vector<wire::Key> older_keys(const wire::KeyTable& keys, const wire::Key& newest) {
  std::vector<wire::Key> older;
  std::ranges::copy_if(keys.all(), std::back_inserter(older), [&newest](const wire::Key& key) {
    return key.device == newest.device && key.id != newest.id;
  });
  return older;
}

void pair_with(const PairOptions& options, const std::string& file) {
  PairingTerms terms = pairing_terms(options, options.sensor, file);
  terms.again = options.again;
  Pairing pairing(std::move(terms), wish_of(options));
  pairing.start();
  if (pairing.by_digits()) {
    stop_on_signals();
    compare_digits(pairing.digits(), options);
    std::fprintf(
        talk(options),
        "They are equal. Now accept them at the sensor: hold its button for 3 seconds, or type "
        "them where stof pair --window asks.\n");
    std::fflush(talk(options));
  }
  const wire::Key key = pairing.finish(std::chrono::minutes(2), [] { return !asked_to_stop(); });
  say_kept(options, key, file, older_keys(value_or_fail(client::read_user_keys(file)), key));
}

// ", role admin, asked for by 192.0.2.7", as the sensor's log has it; "" of one that is older.
std::string asked_text(const wire::PairOffer& offer) {
  if (offer.role == wire::Role::kNone) {
    return "";
  }
  in6_addr from{};
  std::memcpy(&from, offer.from.data(), sizeof from);
  std::string by = posix::make_address(from, 0).host();
  constexpr std::string_view kMapped = "::ffff:";
  by = by.starts_with(kMapped) ? by.substr(kMapped.size()) : by;
  by = by == "255.255.255.255" ? "broadcast" : by;
  return std::string(", role ")
      .append(wire::role_text(offer.role))
      .append(", asked for ")
      .append(by == "::" ? "over this line" : "by " + by);
}

// Whoever holds the cable stands for the button. He types the digits once more: who only has to say
// yes says it before the other end has compared them.
std::uint32_t accepted_digits(const PairOptions& options, const wire::PairOffer& told) {
  const std::string wanted = six_digits(told.digits);
  std::fprintf(
      talk(options),
      "The sensor's digits are %s%s: type them into stof pair. Only if it says that they are "
      "equal, type them here too: ",
      wanted.c_str(), asked_text(told).c_str());
  std::fflush(talk(options));
  std::string typed;
  std::getline(std::cin, typed);
  return digits_in(typed) == wanted ? told.digits : wire::kDigitsEnd;  // which ends it
}

void open_window(const PairOptions& options) {
  if (options.serial.empty()) {
    throw Failure(Exit::kBadInput,
                  "pair: --window takes --serial: over the network nobody opens it");
  }
  client::PairClient client(open_way("pair", options.sensor, options.serial, options.baud),
                            {.name = own_name(options)}, timing(options.timeout_s));
  client::PairWindow window = value_or_end(client.open_window());
  std::fprintf(talk(options),
               "Pairing is open for two minutes: now stof pair SENSOR, where the key shall be.\n");
  std::fflush(talk(options));
  stop_on_signals();
  for (bool asked = false; window.key_id == 0;) {
    if (asked_to_stop()) {
      throw Failure(Exit::kFailure, "pair: was given up: the two minutes have ended");
    }
    if (window.offer && !asked) {
      asked = true;
      window = value_or_end(client.accept(accepted_digits(options, *window.offer)));
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      window = value_or_end(client.open_window());
    }
  }
  if (options.json) {
    say_json({{"key", printed("%08x", window.key_id)}});
  } else {
    say(printed("key %08x is in force: whoever ran stof pair has it", window.key_id));
  }
}

void pair_into(const PairOptions& options, const std::string& own) {
  wire::KeyTable sensor = value_or_fail(client::read_user_keys(options.into));
  if (paired(sensor, value_or_fail(client::read_user_keys(own)), options.device.value_or(1))) {
    if (options.json) {
      say_json({{"key", nullptr}, {"file", own}, {"into", options.into}});
    } else {
      say(options.into + ": has a key of " + own + " already");
    }
    return;
  }
  const wire::Key key = random_key(options);
  if (sensor.count() >= wire::kMostSensorKeys || sensor.add(key) != Status::kOk) {
    throw Failure(Exit::kFailure, options.into +
                                      ": a sensor keeps 16 keys: end one of them first "
                                      "(stof unpair)");
  }
  need_key_room(own);
  value_or_fail(client::write_user_keys(options.into, sensor));
  value_or_end(client::add_user_key(own, key));
  if (options.json) {
    nlohmann::ordered_json json = key_json(key, own);
    json["into"] = options.into;
    say_json(json);
  } else {
    say(printed("key %08x, %s, is in %s and in %s", key.id, options.role.c_str(),
                options.into.c_str(), own.c_str()));
  }
}

}  // namespace

void pair(const PairOptions& options) {
  need_crypto();
  const wire::Key named{.name = wire::key_name(options.name)};
  if (!options.name.empty() && named.name_text() != options.name) {
    throw Failure(Exit::kBadInput,
                  "--name: takes 1 to 32 letters, digits and . _ @ -, and nothing else");
  }
  if (!options.digits.empty() && digits_in(options.digits).size() != kDigits) {
    throw Failure(Exit::kBadInput, "--digits: takes the six digits that the sensor tells");
  }
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

void add_pair(CLI::App& app, PairOptions& options, UnpairOptions& unpairing) {
  const auto add_line = [](CLI::App& command, auto& into) {
    command.add_option("SENSOR", into.sensor,
                       "Serial number, name or HOST[:PORT], none with --serial");
    add_control_flags(command, into);
  };
  CLI::App& command = *app.add_subcommand(
      "pair", "Make a key that a sensor and you share: press its button first, or use its cable");
  show_example(command, "stof pair 192.168.1.20 --role tune",
               "Ends with 0 (a key was made), 1 (no answer, refused, or the digits differ) or 2 "
               "(bad input, or no such key: nothing was done).");
  add_line(command, options);
  command.add_option("--code", options.code,
                     "32 hexadecimal digits of its label: nothing is asked. Better @FILE, or - for "
                     "standard input: a command line is for all users to read");
  command.add_flag("--again", options.again,
                   "Pair also where a key that was not proven at this address has its number: the "
                   "same sensor elsewhere, or a second one with that number");
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
  command.add_option("--name", options.name,
                     "Whose it is, 1 to 32 letters, digits and . _ @ - (default: user@host)");
  command.add_flag("--json", options.json,
                   "A JSON object at the end, and nothing else; what is asked goes to stderr");
  command.callback([&options] { pair(options); });

  CLI::App& ending = *app.add_subcommand("unpair", "End a key of a sensor, or list them");
  show_example(ending, "stof unpair 192.168.1.20 --list",
               "Ends with 0 (done), 1 (no answer, or refused) or 2 (bad input, or no such key: "
               "nothing was done).");
  add_line(ending, unpairing);
  ending.add_option("--id", unpairing.id, "Of the key, 8 digits (default: your own)");
  ending.add_flag("--list", unpairing.list, "Print which keys there are, a line each")
      ->excludes("--id");
  add_json_flag(ending, unpairing.json);
  ending.add_flag("--forget", unpairing.forget, "Only in your file: the sensor --device is gone")
      ->excludes("--list");
  ending.callback([&unpairing] { unpair(unpairing); });
}

}  // namespace stof::host

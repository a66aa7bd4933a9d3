#include "host/cli/pairing.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>
#include <utility>

#include <unistd.h>

#include "firmware/wire/keys/key_text.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/client/control/known_sensors.h"
#include "host/client/control/user_keys.h"
#include "host/text/printed.h"

namespace stof::host {

PairingTerms pairing_terms(const ControlFlags& flags, const std::string& sensor,
                           const std::string& file) {
  return {.sensor = sensor,
          .serial = flags.serial,
          .baud = flags.baud,
          .device = flags.device ? flags.device : serial_device(sensor),
          .timeout_s = flags.timeout_s,
          .file = file};
}

Pairing::Pairing(PairingTerms terms, client::PairWish wish)
    : terms_(std::move(terms)), wish_(std::move(wish)) {
  auto transport = open_way("pair", terms_.sensor, terms_.serial, terms_.baud);
  need_key_room(terms_.file);
  address_ = transport->place();
  client::ControlOptions control = timing(terms_.timeout_s);
  control.device_id = terms_.device ? terms_.device : found_device(terms_.sensor);
  check_called(terms_.sensor, control, {});  // before a key is made; with it once more
  client_ = std::make_unique<client::PairClient>(std::move(transport), wish_, control);
}

void Pairing::start() {
  value_or_end(client_->start());
  need_new(client_->key());
}

bool Pairing::by_digits() const { return wish_.method == wire::PairMethod::kDigits; }

wire::Key Pairing::finish(std::chrono::seconds patience, const std::function<bool()>& goes_on) {
  // Whoever sits between may hold back or forge the last answer: the key itself says whether it is
  // one of the sensor's.
  const auto finished = client_->finish(patience, goes_on);
  const wire::Key key = client_->key();
  if (!finished && !opens_sensor(terms_, key)) {
    throw Failure(Exit::kFailure, finished.error().message);
  }
  value_or_end(client::add_user_key(terms_.file, key));  // the sensor has it already
  if (!terms_.sensor.empty()) {
    check_named(key);
    remember_place(terms_.file, {.named = terms_.sensor, .address = address_}, key.id);
  }
  return key;
}

// A sensor says which number it has, and which id its key gets: neither may be those of another
// one.
void Pairing::need_new(const wire::Key& key) const {
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(terms_.file));
  if (keys.find(key.id) != nullptr) {
    throw Failure(Exit::kFailure, "sensor " + address_ +
                                      ": gave the key the number of one that you have: it "
                                      "imitates another sensor, and nothing was paired");
  }
  const std::span<const wire::Key> all = keys.all();
  const auto same = std::ranges::find(all, key.device, &wire::Key::device);
  if (same == all.end() || terms_.again) {
    return;
  }
  const std::uint32_t there =
      value_or_fail(client::key_proven_at(terms_.file, keys, terms_.sensor));
  const wire::Key* const proven = keys.find(there);
  if (proven == nullptr || proven->device != key.device) {
    throw Failure(
        Exit::kFailure,
        "sensor " + address_ + ": says that it is number " + std::to_string(key.device) +
            ", which your key " + id_text(*same) +
            " is of already, and that was not proven here: give it another number "
            "(stofd --device), or pair with --again if it is the same sensor; nothing was paired");
  }
}

std::string user_and_host() {
  const char* const user = std::getenv("USER");  // NOLINT(concurrency-mt-unsafe): nobody sets one
  std::array<char, 64> host{};
  static_cast<void>(::gethostname(host.data(), host.size() - 1));
  return std::string(user == nullptr ? "user" : user) + "@" + host.data();
}

bool prove_by_code(client::PairWish& wish, std::string_view code) {
  const auto read = wire::code_of(code);
  if (!read) {
    return false;
  }
  wish.method = wire::PairMethod::kCode;
  wish.known.assign(read->begin(), read->end());
  return true;
}

std::string digits_in(std::string_view text) {
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

std::string other_digits(const std::string& typed, std::uint32_t ours) {
  return typed + " was given, the digits here are " + six_digits(ours) +
         ": mistyped, or somebody is between you. Nothing was paired; to begin again press the "
         "button until the sensor says that pairing is open (the first press ends this attempt)";
}

void need_key_room(const std::string& file) {
  value_or_fail(client::update_user_keys(file, [](const wire::KeyTable& keys) {
    return std::expected<wire::KeyTable, client::OpenError>(keys);
  }));
}

std::string kept_text(const wire::Key& key, const std::string& file) {
  return printed("key %08x of sensor %08x, %s, is in %s", key.id, key.device,
                 std::string(wire::role_text(key.role)).c_str(), file.c_str());
}

// The key is kept, but that it is of the sensor with that name is not remembered where it is
// another one's.
void Pairing::check_named(const wire::Key& key) const {
  client::ControlOptions control = timing(terms_.timeout_s);
  control.device_id = key.device;
  wire::KeyTable keys;
  static_cast<void>(keys.add(key));
  try {
    check_called(terms_.sensor, control, keys);
  } catch (const Failure& failure) {
    throw Failure(Exit::kFailure, std::string(failure.what()) + "; " + kept_text(key, terms_.file) +
                                      ": end it with stof unpair ADDRESS where it is not wanted");
  }
}

bool opens_sensor(const PairingTerms& terms, const wire::Key& key) {
  client::ControlOptions control = timing(terms.timeout_s);
  control.device_id = key.device;
  control.unsigned_answers = client::Unsigned::kNever;
  static_cast<void>(control.keys.add(key));
  client::ControlClient client(open_way("pair", terms.sensor, terms.serial, terms.baud), control);
  const auto answer = client.request(wire::SettingsOperation::kKeys, {}, {});
  return answer && answer->result != wire::SettingsResult::kUnknownKey;
}

}  // namespace stof::host

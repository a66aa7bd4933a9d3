#include "host/cli/address.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <arpa/inet.h>

#include "host/cli/config/settings_text.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/stop_signal.h"
#include "host/client/control/link_transport.h"
#include "host/client/printable.h"
#include "host/discovery/discover.h"
#include "posix/interfaces.h"

namespace stof::host {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Operation = wire::SettingsOperation;
using Document = wire::SettingsDocument;
using Result = wire::SettingsResult;

constexpr const char* kTakes =
    "address: takes SENSOR and ADDRESS/BITS, dhcp, both, or link-local; with --serial DEVICE no "
    "SENSOR: try --help";
constexpr auto kListen = 1200ms;  // a beacon comes once a second

bool is_ipv4(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

// "192.168.7.2" of "192.168.7.2/24".
std::string host_of(const std::string& address) { return address.substr(0, address.find('/')); }

// An answer that is no refusal, or throws.
client::ControlAnswer taken(client::ControlAnswer answer, const std::string& place) {
  if (answer.result == Result::kOk) {
    return answer;
  }
  if (answer.result == Result::kUnknownKey) {
    answer.text = unknown_key_text(answer.text);
  } else if (answer.text.empty()) {
    answer.text = answer.result == Result::kBusy ? "is busy: try again"
                                                 : "does not know this request: update the sensor";
  }
  throw Failure(answer.result == Result::kInvalid ? Exit::kBadInput : Exit::kFailure,
                place + ": " + answer.text);
}

// Whatever the sensor says: null where it has no such setting.
Json setting_of(const Json& document, const char* group, const char* name) {
  const auto found = document.find(group);
  return found != document.end() && found->is_object() ? found->value(name, Json()) : Json();
}

std::string text_of(const Json& setting) {
  return setting.is_string() ? setting.get<std::string>() : std::string();
}

Json read_document(client::ControlClient& sensor, Document document, const std::string& place) {
  const auto answer = taken(value_or_end(sensor.request(Operation::kGet, document, {})), place);
  std::optional<Json> parsed = read_json(answer.text);
  if (!parsed || !parsed->is_object() || setting_of(*parsed, "network", "dhcp").is_null()) {
    throw Failure(Exit::kFailure, place + ": has no addresses to set: update the sensor");
  }
  return *std::move(parsed);
}

// Where and how it was heard when it was saved.
struct Kept {
  std::string address;                // numeric; empty: over the cable
  std::string place;                  // of the way by which it was saved
  std::vector<std::string> others{};  // settings that were saved with it
};

// One change of one sensor's address.
class AddressChange {
 public:
  AddressChange(const AddressOptions& options, std::string sensor, AddressWish wish)
      : options_(options),
        sensor_(std::move(sensor)),
        wish_(std::move(wish)),
        file_(keys_file(options.keys)),
        control_(control_of(file_, sensor_, options)) {
    if (options.serial.empty()) {
      control_.unsigned_answers = client::Unsigned::kNever;
    }
  }

  // It is on trial from then on: for a minute.
  void begin() {
    auto transport = open_way("address", sensor_, options_.serial, options_.baud);
    place_ = transport->place();
    client::ControlClient sensor(std::move(transport), control_);
    check_called(sensor, sensor_);
    saved_ = read_document(sensor, Document::kSaved, place_);
    const Json active = read_document(sensor, Document::kActive, place_);
    if (const Json port = setting_of(active, "udp", "port"); port.is_number_unsigned()) {
      port_ = port.get<std::uint16_t>();
    }
    former_ = host_of(text_of(setting_of(active, "network", "address")));
    refuse_taken(sensor.proven());
    stop_on_signals();  // from here on somebody has to be told what comes of it
    static_cast<void>(
        taken(value_or_end(sensor.request(Operation::kSet, {}, wish_.settings())), place_));
    proven_ = sensor.proven();
    if (proven_) {  // from here on nobody else is believed, wherever he answers
      control_.device_id = proven_->device;
      const wire::Key* const key = control_.keys.find(proven_->key_id);
      wire::KeyTable alone;
      static_cast<void>(alone.add(*key));
      control_.keys = alone;
    }
  }

  // Saves it over the cable, which reaches it at any address.
  Kept keep_over_line() {
    client::ControlClient sensor(open_way("address", sensor_, options_.serial, options_.baud),
                                 control_);
    static_cast<void>(taken(value_or_end(sensor.request(Operation::kSave, {}, {})), place_));
    const Json saved = read_document(sensor, Document::kSaved, place_);
    return {.address = {}, .place = place_, .others = others_saved(saved)};
  }

  // As soon as it is heard at its new address.
  std::optional<Kept> keep() {
    const Clock::time_point end =
        Clock::now() +
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.wait_s));
    std::vector<std::string> before;
    while (Clock::now() < end && !asked_to_stop()) {
      const std::optional<client::FoundSensor> found = listen();
      std::vector<std::string> here = found ? found->heard : std::vector<std::string>{};
      std::erase_if(here, [this](const std::string& at) { return !is_wanted(at); });
      if (here.empty() && !wish_.address.empty()) {
        here.push_back(host_of(wish_.address));  // its beacon may be off
      }
      for (const std::string& at : here) {
        if (auto kept = save_at(at, client::open_udp_transport(at + ":" + std::to_string(port_)))) {
          return kept;
        }
      }
      // It is not reached there, but heard: not once, as it may be when it leaves an address, nor
      // at the one that it leaves.
      const auto again = std::ranges::find_first_of(here, before);
      if (found && again != here.end() && heard_at(*found, *again) &&
          (!wish_.address.empty() || (*again != former_ && answers_from(*again, *found)))) {
        if (auto kept = save_elsewhere(*again, *found)) {
          return kept;
        }
      }
      before = here;
    }
    return std::nullopt;
  }

  void remember(const Kept& kept) const {
    if (proven_ && !sensor_.empty()) {
      remember_place(file_, {.named = sensor_, .address = kept.place}, proven_->key_id);
    }
  }

  const std::string& place() const { return place_; }
  // Why there is nothing that was kept, behind the sensor's name.
  std::string failure() const {
    if (said_saved_) {
      return "said that it had saved its new address, and then nothing more: `stof discover` tells "
             "whether it is heard there";
    }
    return std::string(asked_to_stop() ? "was given up before it was heard" : "is not heard") +
           " at its new address: it goes back to the one of before, a minute after the "
           "change, and nothing was saved" +
           (refusal_.empty() ? "" : " (" + refusal_ + ")");
  }
  std::optional<std::uint32_t> device() const {
    return proven_ ? std::optional(proven_->device) : std::nullopt;
  }

 private:
  // Two hosts of one address are heard by chance.
  void refuse_taken(const std::optional<client::ControlClient::Proof>& sensor) const {
    if (wish_.address.empty()) {
      return;
    }
    const std::string host = host_of(wish_.address);
    in_addr address{};
    static_cast<void>(inet_pton(AF_INET, host.c_str(), &address));
    if (posix::is_own_address(address)) {
      throw Failure(Exit::kBadInput, "address: " + host + ": is this computer's own");
    }
    if (!sensor || !options_.serial.empty()) {
      return;
    }
    const auto near = client::discover({.timeout = kListen});
    for (const client::FoundSensor& other : near ? *near : std::vector<client::FoundSensor>{}) {
      if (other.device_id != sensor->device && heard_at(other, host)) {
        throw Failure(Exit::kBadInput, "address: " + host + ": sensor " + other.serial +
                                           " is heard there: give this one another");
      }
    }
  }

  using Way = std::expected<std::unique_ptr<client::ControlTransport>, client::ControlError>;

  static bool heard_at(const client::FoundSensor& sensor, const std::string& address) {
    return std::ranges::find(sensor.heard, address) != sensor.heard.end();
  }

  bool is_wanted(const std::string& address) const {
    if (!wish_.address.empty()) {
      return address == host_of(wish_.address);
    }
    return is_ipv4(address) && (wish_.dhcp || address.starts_with("169.254."));
  }

  std::optional<client::FoundSensor> listen() const {
    const auto sensors = client::discover({.timeout = kListen});
    if (!sensors || !proven_) {
      return std::nullopt;
    }
    const auto found =
        std::ranges::find(*sensors, proven_->device, &client::FoundSensor::device_id);
    return found == sensors->end() ? std::nullopt : std::optional(*found);
  }

  // Anybody can tell all of the link that it is there: what it signs has to come from there. (An
  // address of a wish the sensor itself says, when it is saved.)
  bool answers_from(const std::string& address, const client::FoundSensor& found) const {
    auto way = open_link(found);
    if (!way) {
      return false;
    }
    client::ControlClient sensor(std::move(*way), control_);
    const auto answer = sensor.request(Operation::kGet, Document::kActive, {});
    return answer && sensor.proven() && sensor.proven()->from == address;
  }

  static Way open_link(const client::FoundSensor& found) {
    return client::open_link_transport({.device_id = found.device_id,
                                        .session_id = found.session_id,
                                        .port = found.port,
                                        .called = found.serial});
  }

  // Where it is answered proves nothing: whoever is at that address may hand on what others say. So
  // the sensor itself says, signed, which addresses it has.
  bool says_it_has(client::ControlClient& sensor, const std::string& address) {
    const auto answer = sensor.request(Operation::kGet, Document::kNetwork, {});
    if (!answer || answer->result == Result::kBusy) {
      return false;
    }
    if (answer->result != Result::kOk) {
      refusal_ =
          "it does not say which addresses it has: update it over its cable, or by its "
          "address of now";
      return false;
    }
    const std::optional<Json> said = read_json(answer->text);
    const Json addresses = said && said->is_object() ? said->value("ipv4", Json()) : Json();
    if (addresses.is_array() && std::ranges::find(addresses, Json(address)) != addresses.end()) {
      return true;
    }
    refusal_ = "who answers at " + address +
               " is not the sensor: it says that it has another "
               "address, or none";
    return false;
  }

  // Where it is not reached at its address: another one at which it was heard, IPv6 of the link, or
  // broadcast.
  std::optional<Kept> save_elsewhere(const std::string& address, const client::FoundSensor& found) {
    if (!found.by_link_alone()) {
      if (auto kept = save_at(address, client::open_udp_transport(found.endpoint()))) {
        return kept;
      }
    }
    return save_at(address, open_link(found));
  }

  // None: no answer, or not yet. Only who has the key is believed, and what he refuses for good
  // ends it.
  std::optional<Kept> save_at(const std::string& address, Way way) {
    if (!way) {
      return std::nullopt;
    }
    const std::string place = (*way)->place();
    const std::string host = place.substr(0, place.find(':'));
    client::ControlClient sensor(std::move(*way), control_);
    if (!says_it_has(sensor, address) ||
        (host != address && is_ipv4(host) && !says_it_has(sensor, host))) {
      return std::nullopt;
    }
    const auto answer = sensor.request(Operation::kSave, {}, {});
    if (!answer || answer->result == Result::kBusy) {
      return std::nullopt;
    }
    if (answer->result == Result::kNotSaved) {
      refusal_ = answer->text;  // it is not carried out yet
      return std::nullopt;
    }
    static_cast<void>(taken(*answer, place));
    const auto saved = sensor.request(Operation::kGet, Document::kSaved, {});
    const std::optional<Json> document = saved ? read_json(saved->text) : std::nullopt;
    if (!document || !document->is_object()) {
      said_saved_ = true;  // asked again, it saves no second time
      return std::nullopt;
    }
    if (text_of(setting_of(*document, "network", "address")) != wish_.address) {
      refusal_ = "the minute was over";
      return std::nullopt;
    }
    return Kept{.address = address, .place = place, .others = others_saved(*document)};
  }

  // Whatever else had been changed and not saved is saved now, too.
  std::vector<std::string> others_saved(const Json& saved) const {
    std::vector<std::string> others;
    for (const SettingsChange& change : settings_diff(saved, saved_)) {
      if (!change.path.starts_with("network.")) {
        others.push_back(client::printable(change.path));
      }
    }
    return others;
  }

  const AddressOptions& options_;
  std::string sensor_;  // as the user calls it; empty: the cable
  AddressWish wish_;
  std::string file_;  // of keys
  client::ControlOptions control_;
  std::string place_;
  std::uint16_t port_ = client::kSensorPort;
  std::string former_;  // fixed address; empty: none
  Json saved_;          // before
  std::optional<client::ControlClient::Proof> proven_;
  std::string refusal_;      // the last one to save
  bool said_saved_ = false;  // and what it saved was not told
};

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
}

void tell(const AddressOptions& options, const AddressChange& change, const Kept& kept) {
  if (options.json) {
    nlohmann::ordered_json json{{"device_id", nullptr},
                                {"address", nullptr},
                                {"place", kept.place},
                                {"saved_too", kept.others}};
    if (change.device()) {
      json["device_id"] = *change.device();
    }
    if (!kept.address.empty()) {
      json["address"] = kept.address;
    }
    say_json(json);
    return;
  }
  const std::string who = change.device() ? "sensor " + std::to_string(*change.device()) : "sensor";
  say(kept.address.empty() ? who + ": saved over the cable; nobody has heard it there yet"
                           : who + ": heard at " + kept.address + ", and saved");
  const bool by_broadcast = kept.place.ends_with("by broadcast");
  if (by_broadcast || kept.place.starts_with("[fe80:")) {
    say(std::string("this computer has no address of that network: it reaches the sensor by ") +
        (by_broadcast ? "broadcast" : "IPv6 of the link") + " alone");
  }
  if (!kept.others.empty()) {
    say("saved with it, because it was changed and not saved before: " + joined(kept.others));
  }
}

// Of the words: the sensor first, but over a cable.
std::string take_sensor(const AddressOptions& options, std::vector<std::string>& words) {
  if (words.size() < (options.serial.empty() ? 2U : 1U)) {
    throw Failure(Exit::kBadInput, kTakes);
  }
  if (!options.serial.empty()) {
    return {};
  }
  std::string sensor = words.front();
  words.erase(words.begin());
  return sensor;
}

}  // namespace

std::string AddressWish::settings() const {
  nlohmann::ordered_json network{{"dhcp", dhcp}, {"address", address}, {"gateway", gateway}};
  if (link_local) {
    network["link_local"] = true;
  }
  return nlohmann::ordered_json{{"network", network}}.dump();
}

AddressWish address_wish(const std::vector<std::string>& words, const std::string& gateway) {
  AddressWish wish{.gateway = gateway};
  for (const std::string& word : words) {
    const bool again = (word == "dhcp" && wish.dhcp) || (word == "link-local" && wish.link_local) ||
                       (word.find('/') != std::string::npos && !wish.address.empty());
    if (again) {
      throw Failure(Exit::kBadInput, "address: " + word + ": one of each kind alone");
    }
    if (word == "dhcp") {
      wish.dhcp = true;
    } else if (word == "link-local") {
      wish.link_local = true;
    } else if (is_ipv4(host_of(word)) && word.find('/') != std::string::npos) {
      wish.address = word;
    } else {
      throw Failure(Exit::kBadInput, "address: " + word +
                                         ": takes an address with the bits of its network, such as "
                                         "192.168.7.2/24, dhcp, or link-local");
    }
  }
  if (wish.link_local && words.size() > 1) {
    throw Failure(Exit::kBadInput, "address: link-local: stands alone");
  }
  if (!gateway.empty() && (wish.address.empty() || !is_ipv4(gateway))) {
    throw Failure(Exit::kBadInput,
                  "--gateway: takes an address such as 192.168.7.1, beside an ADDRESS/BITS");
  }
  return wish;
}

void set_address(const AddressOptions& options) {
  need_crypto();
  std::vector<std::string> words = options.words;
  const std::string sensor = take_sensor(options, words);
  AddressChange change(options, sensor, address_wish(words, options.gateway));
  change.begin();
  if (!options.serial.empty()) {
    tell(options, change, change.keep_over_line());
    return;
  }
  std::optional<Kept> kept = change.keep();
  if (!kept) {
    throw Failure(Exit::kFailure, change.place() + ": " + change.failure());
  }
  change.remember(*kept);
  tell(options, change, *kept);
}

void add_address(CLI::App& app, AddressOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "address", "Give a sensor another address, also where it and this computer share no network");
  show_example(
      command, "stof address 00000001 192.168.7.2/24",
      "The sensor takes it for a minute, and is told to keep it as soon as it is heard there; else "
      "it goes back by itself. Takes a key of role admin (stof pair), or the cable.\n"
      "Ends with 0 (heard there and saved), 1 (no answer, refused, or not heard there: it goes "
      "back, nothing was saved) or 2 (bad input, or an address that the sensor does not take: "
      "nothing changed).");
  command.add_option("WORDS", options.words,
                     "SENSOR (serial number, name or HOST[:PORT]; none with --serial), then "
                     "ADDRESS/BITS, dhcp or both, or link-local");
  command.add_option("--gateway", options.gateway,
                     "To all other networks; of dhcp alone it comes with the address");
  command
      .add_option("--wait", options.wait_s,
                  "Seconds to hear it at its new address; it keeps that for a minute")
      ->check(CLI::Range(1.0, 55.0))
      ->capture_default_str();
  add_json_flag(command, options.json);
  add_control_flags(command, options);
  command.callback([&options] { set_address(options); });
}

}  // namespace stof::host

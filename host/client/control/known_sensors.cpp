#include "host/client/control/known_sensors.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "host/client/control/own_file.h"
#include "host/client/sensor_socket.h"

namespace stof::client {
namespace {

constexpr std::string_view kFirstLine = "stof sensors 1\n";
constexpr std::size_t kMostPlaces = 64;  // the oldest goes first
constexpr std::size_t kIdDigits = 8;
constexpr std::size_t kMostPlaceBytes = 256 + 8;  // a host name and a port
constexpr std::size_t kMostText =
    kFirstLine.size() + kMostPlaces * (kIdDigits + 1 + kMostPlaceBytes + 1);

struct Known {
  std::uint32_t key_id = 0;
  std::string place;
};
using Sensors = std::vector<Known>;

std::string file_of(const std::string& key_file) { return key_file + ".sensors"; }

bool is_place(std::string_view text) {
  return !text.empty() && text.size() <= kMostPlaceBytes &&
         std::ranges::all_of(text, [](char c) { return c > ' ' && c < '\x7F'; });
}

// With its port, as it is kept; empty: nothing that could be kept.
std::string normal(std::string_view named) {
  const auto parts = posix::split_host_port(named, kDefaultPort);
  if (!parts) {
    return {};
  }
  std::string place =
      (parts->host.find(':') == std::string::npos ? parts->host : "[" + parts->host + "]") + ":" +
      std::to_string(parts->port);
  std::ranges::transform(place, place.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return is_place(place) ? place : std::string{};
}

// Of a number, as it is kept; of a name none.
std::vector<std::string> addresses_of(std::string_view named) {
  std::vector<std::string> out;
  const auto parts = posix::split_host_port(named, kDefaultPort);
  if (!parts) {
    return out;
  }
  if (const auto addresses = posix::resolve(*parts, posix::Names::kAddressesOnly)) {
    for (const posix::SocketAddress& address : *addresses) {
      out.push_back(normal(address.text()));
    }
  }
  return out;
}

// nullopt: not such a file.
std::optional<Sensors> parse(std::string_view text) {
  if (text.size() > kMostText || !text.starts_with(kFirstLine)) {
    return std::nullopt;
  }
  Sensors known;
  text.remove_prefix(kFirstLine.size());
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos || end < kIdDigits + 2 || text[kIdDigits] != ' ') {
      return std::nullopt;
    }
    Known one{.place = std::string(text.substr(kIdDigits + 1, end - kIdDigits - 1))};
    const char* const digits = text.data();
    const auto read = std::from_chars(digits, digits + kIdDigits, one.key_id, 16);
    if (read.ptr != digits + kIdDigits || !is_place(one.place)) {
      return std::nullopt;
    }
    known.push_back(std::move(one));
    text.remove_prefix(end + 1);
  }
  return known.size() <= kMostPlaces ? std::optional(std::move(known)) : std::nullopt;
}

std::string id_text(std::uint32_t id) {
  std::array<char, kIdDigits + 1> text{};
  std::snprintf(text.data(), text.size(), "%08x", id);
  return text.data();
}

std::string text_of(const Sensors& known) {
  std::string text(kFirstLine);
  for (const Known& one : known) {
    text.append(id_text(one.key_id)).append(" ").append(one.place).append("\n");
  }
  return text;
}

// Of those whose keys there are.
std::expected<Sensors, OpenError> read_known(const std::string& key_file,
                                             const wire::KeyTable& keys) {
  const std::string file = file_of(key_file);
  auto text = read_own_file(file, kMostText, "others may change it: chmod 600");
  if (!text) {
    return std::unexpected(std::move(text.error()));
  }
  if (!*text) {
    return Sensors{};
  }
  std::optional<Sensors> known = parse({(*text)->data(), (*text)->size()});
  if (!known) {
    return refuse_file(Status::kCorrupt, file,
                       "damaged, or of a later version: remove it, and name sensors by --device");
  }
  std::erase_if(*known, [&](const Known& one) { return keys.find(one.key_id) == nullptr; });
  return *std::move(known);
}

std::optional<std::uint32_t> find(const Sensors& known, const std::string& place) {
  const auto found = std::ranges::find(known, place, &Known::place);
  return found == known.end() ? std::nullopt : std::optional(found->key_id);
}

// The name as it is given: an address may have been given to another sensor, and a name leads where
// whoever answers for it wants.
std::optional<std::uint32_t> key_at(const Sensors& known, std::string_view named) {
  if (const auto key = find(known, normal(named))) {
    return key;
  }
  for (const std::string& address :
       known.empty() ? std::vector<std::string>{} : addresses_of(named)) {
    if (const auto key = find(known, address)) {
      return key;
    }
  }
  return std::nullopt;
}

std::string joined(const std::set<std::string>& words) {
  std::string list;
  for (const std::string& word : words) {
    list += (list.empty() ? "" : ", ") + word;
  }
  return list;
}

// Empty: there is none.
std::string doubt_of(const wire::KeyTable& keys, const Sensors& known,
                     std::optional<std::uint32_t> asked) {
  std::set<std::string> devices;
  std::map<std::uint32_t, std::set<std::string>> proven;  // ids by number
  for (const wire::Key& key : keys.all()) {
    if (asked.value_or(key.device) == key.device) {
      devices.insert(std::to_string(key.device));
      if (std::ranges::find(known, key.id, &Known::key_id) != known.end()) {
        proven[key.device].insert(id_text(key.id));
      }
    }
  }
  if (devices.size() > 1) {
    return "your keys are of several sensors (" + joined(devices) +
           "), and none of them was proven under this name or address: name the one that is meant";
  }
  const auto twice =
      std::ranges::find_if(proven, [](const auto& of) { return of.second.size() > 1; });
  return twice == proven.end()
             ? ""
             : "your keys are of several sensors with number " + std::to_string(twice->first) +
                   " (keys " + joined(twice->second) +
                   "), and none of them was proven under this name or address: name the one that "
                   "is meant";
}

std::expected<Meant, OpenError> meant_by_key(const std::string& key_file,
                                             const wire::KeyTable& keys, const Asked& asked) {
  const wire::Key* const key = keys.find(asked.key_id);
  if (key == nullptr) {
    return refuse_file(Status::kInvalidArgument, key_file,
                       "has no key " + id_text(asked.key_id) + ": name one that is in it");
  }
  if (asked.device.value_or(key->device) != key->device) {
    return refuse_file(Status::kInvalidArgument, key_file,
                       "key " + id_text(key->id) + " is of number " + std::to_string(key->device) +
                           ", not " + std::to_string(*asked.device) + ": name one of them alone");
  }
  Meant meant{.device = key->device};
  static_cast<void>(meant.keys.add(*key));
  return meant;
}

}  // namespace

std::expected<Meant, OpenError> meant_sensor(const std::string& key_file,
                                             const wire::KeyTable& keys, std::string_view named,
                                             const Asked& asked) {
  if (asked.key_id != 0) {
    return meant_by_key(key_file, keys, asked);
  }
  const std::expected<Sensors, OpenError> known =
      keys.count() == 0 ? Sensors{} : read_known(key_file, keys);
  if (!known) {
    return std::unexpected(known.error());
  }
  const std::optional<std::uint32_t> id = key_at(*known, named);
  const wire::Key* const key = id ? keys.find(*id) : nullptr;
  if (key != nullptr && asked.device.value_or(key->device) == key->device) {
    Meant meant{.device = key->device};
    static_cast<void>(meant.keys.add(*key));
    return meant;
  }
  return Meant{.device = asked.device, .keys = keys, .doubt = doubt_of(keys, *known, asked.device)};
}

std::expected<std::uint32_t, OpenError> key_proven_at(const std::string& key_file,
                                                      const wire::KeyTable& keys,
                                                      std::string_view named) {
  const std::expected<Sensors, OpenError> known = read_known(key_file, keys);
  if (!known) {
    return std::unexpected(known.error());
  }
  return key_at(*known, named).value_or(0);
}

std::expected<void, OpenError> remember_sensor(const std::string& key_file,
                                               const wire::KeyTable& keys, const Place& place,
                                               std::uint32_t key_id) {
  std::set<std::string> places{normal(place.named), normal(place.address)};
  places.erase(std::string{});
  const auto all_known = [&](const Sensors& known) {
    return std::ranges::all_of(places,
                               [&](const std::string& one) { return find(known, one) == key_id; });
  };
  // Most often it is known, and the user's folder need not be one that he can write.
  if (const auto known = read_known(key_file, keys); known && all_known(*known)) {
    return {};
  }
  const auto lock = lock_own_file(key_file);
  if (!lock) {
    return std::unexpected(lock.error());
  }
  std::expected<Sensors, OpenError> known = read_known(key_file, keys);
  if (!known) {
    return std::unexpected(known.error());
  }
  std::erase_if(*known, [&](const Known& one) { return places.contains(one.place); });
  for (const std::string& one : places) {
    known->push_back({.key_id = key_id, .place = one});
  }
  if (known->size() > kMostPlaces) {
    known->erase(known->begin(), known->end() - static_cast<std::ptrdiff_t>(kMostPlaces));
  }
  return write_own_file(file_of(key_file), text_of(*known));
}

std::string other_sensor(std::uint32_t answers, std::uint32_t meant) {
  const std::string number = std::to_string(answers);
  return "says that it is number " + number + ", but you named " + std::to_string(meant) +
         ", or proved it at this address: somebody stands between you, or the addresses have "
         "changed; name it by --device " +
         number + " if it is the one you mean";
}

}  // namespace stof::client

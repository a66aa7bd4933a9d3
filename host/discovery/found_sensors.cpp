#include "host/discovery/found_sensors.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "firmware/wire/dns.h"
#include "firmware/wire/messages/announce.h"
#include "host/client/printable.h"

namespace stof::client {
namespace {

namespace dns = wire::dns;

constexpr unsigned kMostRecords = 256;
constexpr std::size_t kMostHeard = 16;

std::string endpoint_of(const std::string& address, std::uint16_t port) {
  const bool ipv6 = address.find(':') != std::string::npos;
  return (ipv6 ? "[" + address + "]" : address) + ":" + std::to_string(port);
}

// Of IPv6: it means something by one interface alone.
bool is_link_local(const std::string& address) { return address.find('%') != std::string::npos; }

bool has_answered(const FoundSensor& sensor) {
  return sensor.answers_link || sensor.methods[static_cast<std::size_t>(DiscoveryMethod::kDirect)];
}

// Up to the first 0.
std::string shown(std::string_view text) { return printable(text.substr(0, text.find('\0'))); }

template <std::size_t kSize>
std::string shown(const std::array<char, kSize>& text) {
  return shown(std::string_view(text.data(), text.size()));
}

// The value of one key of a TXT record.
std::string text_value(std::span<const std::byte> data, std::string_view key) {
  while (!data.empty()) {
    const std::size_t length = std::to_integer<std::size_t>(data[0]);
    data = data.subspan(1);
    if (length > data.size()) {
      break;
    }
    const std::string_view entry(reinterpret_cast<const char*>(data.data()), length);
    if (entry.size() > key.size() && entry.starts_with(key) && entry[key.size()] == '=') {
      return shown(entry.substr(key.size() + 1));
    }
    data = data.subspan(length);
  }
  return {};
}

struct Instance {
  dns::Name name;
  std::uint16_t port = 0;
  std::span<const std::byte> text{};
};

bool is_ours(const dns::Name& instance) {
  return instance.parent() == dns::Name{"_stof", "_udp", "local"};
}

Instance& instance_of(std::vector<Instance>& instances, const dns::Name& name) {
  const auto known = std::ranges::find(instances, name, &Instance::name);
  return known != instances.end() ? *known : instances.emplace_back(Instance{.name = name});
}

std::vector<Instance> read_instances(std::span<const std::byte> message) {
  std::vector<Instance> instances;
  dns::Reader reader(message);
  const auto header = reader.header();
  if (!header || (header->flags & dns::kResponse) == 0) {
    return instances;
  }
  for (unsigned i = 0; i < header->questions; ++i) {
    if (!reader.question()) {
      return instances;
    }
  }
  const unsigned records = unsigned{header->answers} + header->authorities + header->additionals;
  for (unsigned i = 0; i < std::min(records, kMostRecords); ++i) {
    const auto record = reader.record();
    if (!record) {
      break;
    }
    if (record->ttl_s == 0 || !is_ours(record->name)) {
      continue;  // leaving, or of something else
    }
    if (record->type == dns::Type::kSrv && record->data.size() > 6) {
      instance_of(instances, record->name).port =
          static_cast<std::uint16_t>((std::to_integer<unsigned>(record->data[4]) << 8) |
                                     std::to_integer<unsigned>(record->data[5]));
    } else if (record->type == dns::Type::kTxt) {
      instance_of(instances, record->name).text = record->data;
    }
  }
  return instances;
}

}  // namespace

const char* to_string(DiscoveryMethod method) noexcept {
  switch (method) {
    case DiscoveryMethod::kMdns:
      return "mdns";
    case DiscoveryMethod::kBeacon:
      return "beacon";
    case DiscoveryMethod::kDirect:
      return "direct";
  }
  return "unknown";
}

std::string FoundSensor::endpoint() const { return endpoint_of(address, port); }

FoundSensor& FoundSensors::entry(std::uint32_t device_id, const std::string& serial,
                                 std::uint16_t port) {
  const auto known = std::ranges::find_if(sensors_, [&](const FoundSensor& sensor) {
    return sensor.device_id == device_id && sensor.serial == serial && sensor.port == port;
  });
  if (known != sensors_.end()) {
    return *known;
  }
  FoundSensor made{.device_id = device_id, .serial = serial, .port = port};
  if (sensors_.size() < kMostFound) {
    return sensors_.emplace_back(std::move(made));
  }
  // The newest of those that were only announced goes.
  const auto announced =
      std::ranges::find_if(sensors_.rbegin(), sensors_.rend(),
                           [](const FoundSensor& one) { return !has_answered(one); });
  FoundSensor& place = announced == sensors_.rend() ? sensors_.back() : *announced;
  const auto at = static_cast<std::size_t>(&place - sensors_.data());
  std::erase_if(answers_, [at](const Answer& one) { return one.sensor == at; });
  place = std::move(made);
  return place;
}

void FoundSensors::found_by(FoundSensor& sensor, const std::string& from, DiscoveryMethod method) {
  const auto better = std::span(sensor.methods).subspan(static_cast<std::size_t>(method));
  // Of two that answer the one that all programs take.
  const bool plainer =
      method == DiscoveryMethod::kDirect && is_link_local(sensor.address) && !is_link_local(from);
  if (plainer || sensor.address == kNoAddress ||
      std::ranges::none_of(better, [](bool known) { return known; })) {
    sensor.address = from;
  }
  if (from != kNoAddress) {
    note_address(sensor, from, method);
  }
  sensor.methods[static_cast<std::size_t>(method)] = true;
}

void FoundSensors::note_address(FoundSensor& sensor, const std::string& from,
                                DiscoveryMethod method) {
  // Any of its addresses may be one that this machine reaches.
  const bool answers = sensor.methods[static_cast<std::size_t>(DiscoveryMethod::kDirect)] ||
                       method == DiscoveryMethod::kDirect;
  std::string endpoint = endpoint_of(from, sensor.port);
  if (!answers && asked_.size() < kMostFound && asked_.insert(endpoint).second) {
    silent_.push_back(std::move(endpoint));
  }
  if (sensor.heard.size() < kMostHeard &&
      std::ranges::find(sensor.heard, from) == sensor.heard.end()) {
    sensor.heard.push_back(from);
  }
}

void FoundSensors::begin_answers() noexcept {
  answers_.clear();
  open_ = true;
}

void FoundSensors::note_answer(FoundSensor& sensor, std::uint32_t session,
                               const std::string& from) {
  const auto at = static_cast<std::size_t>(&sensor - sensors_.data());
  const auto known = std::ranges::find(answers_, at, &Answer::sensor);
  if (!open_ || known == answers_.end()) {
    if (open_) {
      answers_.push_back({.sensor = at, .session = session, .from = from});
    }
    return;
  }
  if (known->session != session) {
    sensor.rival = sensor.address == from ? known->from : from;
  }
}

bool FoundSensors::take_packet(std::span<const std::byte> datagram, const std::string& from,
                               DiscoveryMethod method) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet || packet->header.type != wire::PacketType::kAnnounce) {
    return false;
  }
  const Result<wire::Announce> announce = wire::decode_announce(packet->payload);
  if (!announce) {
    return false;
  }
  FoundSensor& sensor =
      entry(packet->header.origin.device_id, shown(announce->serial), announce->port);
  found_by(sensor, from, method);
  sensor.session_id = packet->header.origin.session_id;
  if (announce->request_id != 0) {
    note_answer(sensor, sensor.session_id, from);
  }
  sensor.answers_link =
      sensor.answers_link || (method == DiscoveryMethod::kBeacon && announce->request_id != 0);
  if (std::string name = shown(announce->name); name != sensor.name) {
    sensor.other_name = std::exchange(sensor.name, std::move(name));
  }
  sensor.version = shown(announce->version);
  sensor.board = shown(announce->board);
  sensor.health = packet->header.frame.health;
  sensor.rate_millihertz = announce->rate_millihertz;
  sensor.standby = static_cast<wire::SensorState>(announce->state) == wire::SensorState::kStandby;
  sensor.subscribers = announce->subscribers;
  sensor.most_subscribers = announce->most_subscribers;
  return true;
}

void FoundSensors::take_mdns(std::span<const std::byte> message, const std::string& from) {
  for (const Instance& instance : read_instances(message)) {
    const std::string id = text_value(instance.text, "id");
    std::uint32_t device_id = 0;
    const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), device_id, 16);
    if (instance.port == 0 || error != std::errc{} || end != id.data() + id.size()) {
      continue;
    }
    FoundSensor& sensor = entry(device_id, text_value(instance.text, "serial"), instance.port);
    found_by(sensor, from, DiscoveryMethod::kMdns);
    if (!sensor.health) {
      sensor.name = text_value(instance.text, "name");
      sensor.version = text_value(instance.text, "version");
      sensor.board = text_value(instance.text, "board");
    }
  }
}

std::vector<std::string> FoundSensors::take_silent() { return std::exchange(silent_, {}); }

std::vector<FoundSensor> FoundSensors::sorted() const {
  std::vector<FoundSensor> sensors = sensors_;
  std::ranges::sort(
      sensors, {}, [](const FoundSensor& sensor) { return std::pair(sensor.serial, sensor.port); });
  return sensors;
}

}  // namespace stof::client

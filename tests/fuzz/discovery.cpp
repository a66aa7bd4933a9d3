#include <string>

#include "host/discovery/found_sensors.h"
#include "tests/fuzz/fuzz_input.h"

// What answers whoever looks for sensors: announcements, and messages of multicast DNS.
void stof::fuzz::run(std::span<const std::byte> input) {
  client::FoundSensors found;
  for_each_record(input, [&](const Record& record) {
    const std::string from = record.peer() % 2 == 0 ? "10.0.0.1" : "fe80::1%2";
    if ((record.flags & kSeal) != 0) {
      wire::DatagramBuffer space{};
      found.take_packet(sealed(record.bytes, space), from, client::DiscoveryMethod::kBeacon);
      found.take_packet(record.bytes, from, client::DiscoveryMethod::kDirect);
    } else {
      found.take_mdns(record.bytes, from);
    }
    for (const std::string& endpoint : found.take_silent()) {
      require(!endpoint.empty());
    }
  });
  for (const client::FoundSensor& sensor : found.sorted()) {
    require(!sensor.endpoint().empty());
  }
}

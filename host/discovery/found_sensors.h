#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "firmware/wire/packet.h"

namespace stof::client {

// How a sensor was found. An answer to a question of ours is the surest: packets go both ways.
enum class DiscoveryMethod : std::uint8_t { kMdns, kBeacon, kDirect };
inline constexpr std::size_t kDiscoveryMethods = 3;
const char* to_string(DiscoveryMethod method) noexcept;

// That are kept: it bounds what strangers can make us keep. Who has answered stays.
inline constexpr std::size_t kMostFound = 1000;

// From which a sensor answers by broadcast that has no IPv4 address.
inline constexpr const char* kNoAddress = "0.0.0.0";

struct FoundSensor {
  std::uint32_t device_id = 0;
  std::uint32_t session_id = 0;  // of the newest datagram; 0: known from multicast DNS alone
  std::string serial{};
  std::string name{};
  std::string other_name{};  // that a datagram of before gave; empty: there is none
  std::string version{};
  std::string board{};
  // Numeric, of the surest method; of link-local IPv6 with %interface; kNoAddress: it has none.
  std::string address{};
  std::uint16_t port = 0;
  std::array<bool, kDiscoveryMethods> methods{};
  bool answers_link = false;         // a question to a whole link, by broadcast
  std::vector<std::string> heard{};  // addresses that it sent from, as `address`
  // Where another one is that answered the same question with this number, port and another
  // session: no sensor has two at once. Empty: there is none.
  std::string rival{};
  // Known from beacons and answers only.
  std::optional<wire::Health> health{};
  std::optional<std::uint32_t> rate_millihertz{};  // frames of its last second, 1/1000 Hz
  bool standby = false;                            // nobody subscribes, so there are no frames
  unsigned subscribers = 0;
  unsigned most_subscribers = 0;

  // HOST:PORT, IPv6 in brackets.
  std::string endpoint() const;
  // It is heard, and packets go to it by broadcast alone: it has no address of a network of this
  // machine, or this machine none of its.
  bool by_link_alone() const {
    return answers_link && !methods[static_cast<std::size_t>(DiscoveryMethod::kDirect)];
  }
};

// The sensors that many datagrams name, each once. No socket.
class FoundSensors {
 public:
  // Until end_answers() answers are to one question, which a sensor answers in one session.
  void begin_answers() noexcept;
  void end_answers() noexcept { open_ = false; }
  // One datagram of the wire format. False: it is not an announcement of a sensor.
  bool take_packet(std::span<const std::byte> datagram, const std::string& from,
                   DiscoveryMethod method);
  // One answer of multicast DNS, any bytes.
  void take_mdns(std::span<const std::byte> message, const std::string& from);

  // Endpoints of sensors that were announced since the last call and have not answered themselves.
  std::vector<std::string> take_silent();
  // By serial number.
  std::vector<FoundSensor> sorted() const;

 private:
  FoundSensor& entry(std::uint32_t device_id, const std::string& serial, std::uint16_t port);
  void found_by(FoundSensor& sensor, const std::string& from, DiscoveryMethod method);
  void note_answer(FoundSensor& sensor, std::uint32_t session, const std::string& from);
  void note_address(FoundSensor& sensor, const std::string& from, DiscoveryMethod method);

  // Who has answered, and in which session.
  struct Answer {
    std::size_t sensor = 0;  // in sensors_
    std::uint32_t session = 0;
    std::string from;
  };

  std::vector<FoundSensor> sensors_;
  std::vector<Answer> answers_;  // to the question that was asked last, one a sensor
  bool open_ = false;
  std::vector<std::string> silent_;
  std::set<std::string> asked_;  // that were among these
};

}  // namespace stof::client

#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "tests/campaign/network.h"
#include "tests/support/random.h"

namespace stof::campaign {

// What somebody on the network does who sees what passes. He never forges a frame that a sensor
// could have sent: docs/SECURITY.md, "What is not protected", says that nothing keeps him from it.
enum class Attack : std::uint8_t {
  kNone,
  kJunk,            // 20,000 datagrams of random bytes a second to the robot
  kStale,           // 20,000 frames a second that were sent before
  kLies,            // headers, health, events and calibration that no sensor can have sent
  kOtherSession,    // one frame of a start that never was
  kForgedRequests,  // in the robot's name, to the sensor: subscribe and unsubscribe, guessed
                    // cookies
  kRequestFlood,    // 3,000 damaged requests a second to the sensor
  kUnreachable,     // "port unreachable" for the robot, all the time
};

class Attacker {
 public:
  explicit Attacker(std::uint64_t seed) noexcept : random_(seed) {}

  void arm(Attack attack, const Span& span) noexcept {
    attack_ = attack;
    span_ = span;
    captured_.clear();
    done_ = false;
  }
  // Does what falls into that time. Call before the robot reads it.
  void act(Network& network, hal::Time from, hal::Time until);

 private:
  using Bytes = std::vector<std::byte>;

  void flood_robot(Network& network, hal::Time from, hal::Time until);
  void lie(Network& network, hal::Time at);
  void ask(Network& network);
  Bytes junk();
  Bytes changed_header(const Bytes& datagram);
  Bytes forged_request();

  test::Random random_;
  Attack attack_ = Attack::kNone;
  Span span_{};
  std::vector<Bytes> captured_;
  bool done_ = false;
};

}  // namespace stof::campaign

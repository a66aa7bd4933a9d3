#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/client/arrival_clock.h"
#include "host/client/control/subscription.h"
#include "host/client/reassembler.h"
#include "host/client/session/link_watch.h"
#include "tests/campaign/network.h"
#include "tests/campaign/wall.h"

namespace stof::campaign {

// How the robot can notice that something is wrong. Those behind kCounted are somebody's word for
// it: libstof's (packets are missing, LinkState) or the sensor's (a frame's own fields, a
// condition, health).
enum class Sign : std::uint8_t { kCounted, kIncomplete, kFlagged, kCondition, kHealth, kLink };

struct SignAt {
  client::Time at;
  Sign sign;
};

// Why a delivered frame is false. kNone: it is true.
enum class Falsehood : std::uint8_t {
  kNone,
  kNoEdge,        // no camera was exposed at its time
  kNotNewer,      // than one delivered before
  kOtherPixels,   // its depth is not that of the wall at its edge, as its sensors saw it
  kStale,         // older than promised
  kWrongSensors,  // depth of a sensor that it says is missing
};
inline constexpr std::size_t kFalsehoods = 6;

struct RobotCounts {
  std::uint64_t pushed = 0;  // datagrams given to libstof's reassembler
  std::uint64_t delivered = 0;
  std::uint64_t whole = 0;  // of both sensors, with all packets, and good
  std::array<std::uint64_t, kFalsehoods> falsehoods{};
  client::Duration oldest{};  // delivery less exposure

  std::uint64_t false_frames() const noexcept {
    std::uint64_t sum = 0;
    for (std::size_t i = 1; i < kFalsehoods; ++i) {
      sum += falsehoods[i];
    }
    return sum;
  }
};

// What the robot is judged by; another one than its rig's or libstof's checks the judge.
struct Belief {
  RigSize truth{};
  std::optional<client::Duration> max_age{};
};

// A robot with libstof's parts, by its own clock: subscribes, receives, and judges every frame by
// what the emulator knows. It looks every millisecond.
class Robot {
 public:
  // A frame is stale beyond three periods to its sending, 300 ms of sending, one period and 100 ms
  // of waiting at the robot: docs/RELIABILITY.md.
  static constexpr client::Duration kOldest = std::chrono::milliseconds(3 * 33 + 300 + 33 + 100);
  static constexpr client::Duration kLook = std::chrono::milliseconds(1);

  Robot(const EdgeLog& log, const Belief& belief, hal::Time start);

  // Receives until then, and answers the network's sensor.
  void run(Network& network, hal::Time until);

  // It does not run then; what arrives waits in its socket.
  void sleep(const Span& span) noexcept { asleep_ = span; }
  // Its wall clock, which stamps arrivals, jumps.
  void set_wall_clock(hal::Time at, hal::Duration by) noexcept {
    jump_at_ = client_time(at);
    jump_by_ = by;
  }

  const RobotCounts& counts() const noexcept { return counts_; }
  const std::vector<SignAt>& signs() const noexcept { return signs_; }
  // When whole, true frames were delivered.
  const std::vector<client::Time>& whole() const noexcept { return whole_; }
  // When it was last not well: the stream silent, the newest frame not whole, or a condition
  // active.
  client::Time unwell_until() const noexcept { return unwell_until_; }
  const client::Statistics& statistics() const noexcept { return reassembler_.statistics(); }
  const std::optional<wire::HealthReport>& health() const noexcept { return reassembler_.health(); }
  // Before 8 hours: the records alone; what was learned stays.
  void forget_records();

  static hal::Peer peer() noexcept;

 private:
  void look(client::Time now);
  void read(Network& network, client::Time until);
  void push(Network& network, const Network::Arrival& arrival, client::Time now);
  void take(client::Time now);
  Falsehood judge(const client::Frame& frame, client::Time now);
  void note(client::Time at, Sign sign);
  std::chrono::nanoseconds wall(client::Time at) const noexcept;

  const EdgeLog& log_;
  RigSize size_;
  client::Time now_;
  Span asleep_{};
  bool slept_ = false;
  client::Time jump_at_ = client::Time::max();
  std::chrono::nanoseconds jump_by_{};

  client::ArrivalClock arrivals_;
  client::Reassembler reassembler_;
  client::LinkWatch watch_;
  client::Subscription subscription_;
  std::optional<client::Frame> held_;  // of this look
  std::uint64_t troubles_ = 0;         // sum of the statistics that count damage
  std::optional<std::int64_t> newest_ns_;
  bool whole_now_ = false;

  RobotCounts counts_;
  std::vector<SignAt> signs_;
  std::vector<client::Time> whole_;
  client::Time unwell_until_;
};

}  // namespace stof::campaign

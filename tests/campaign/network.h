#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "hal/datagram_port.h"
#include "hal/emu/devices/datagram_port.h"
#include "host/client/frame/frame.h"
#include "host/netem/impairment.h"
#include "tests/campaign/devices.h"

namespace stof::campaign {

// The same moment by the names of both sides.
inline client::Time client_time(hal::Time at) noexcept {
  return client::Time(at.time_since_epoch());
}

// The sensor's port with its faults, and the network from there to the robot and back, in emulated
// time.
class Network final : public hal::DatagramPort {
 public:
  struct Arrival {
    client::Time at;
    std::vector<std::byte> bytes;
  };

  Network(Clock& clock, const emu::FaultPlan& faults) : clock_(clock), port_(64, faults) {}

  // Faults that begin and end at any moment: kVanish takes nothing and says kDeviceError, kDrop is
  // a queue that stays full (kWouldBlock).
  TimedFault fault{};
  // A bad network for what is sent in that span.
  void impair(const Span& span, const netem::ImpairmentOptions& options) {
    bad_ = span;
    impairment_.emplace(options);
  }
  // Somebody else's datagrams: to the robot, at any time from now on; to the sensor, now.
  void inject(Arrival arrival);
  void to_sensor(std::span<const std::byte> bytes, const hal::Peer& from);
  void refuse(const hal::Peer& peer) { port_.refuse(peer); }

  // What arrives at the robot not later than that, in order.
  std::optional<Arrival> next(client::Time until);
  // What the sensor sent last, newest at the back; for who replays and forges.
  const std::deque<std::vector<std::byte>>& overheard() const noexcept { return overheard_; }
  // Times of the first and the last datagram of a range of calls of the port.
  std::optional<hal::Time> time_of_call(std::uint32_t call) const noexcept;

  Status send(const hal::Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override;
  Result<hal::Received> receive(std::span<std::byte> space,
                                hal::Duration timeout) noexcept override {
    return port_.receive(space, timeout);
  }
  std::uint64_t overruns() const noexcept override { return port_.overruns(); }
  bool take_unreachable(hal::Peer& peer) noexcept override { return port_.take_unreachable(peer); }
  std::uint16_t port() const noexcept override { return port_.port(); }

 private:
  static constexpr std::size_t kOverheard = 64;
  static constexpr std::size_t kTimedCalls = 4096;

  void carry();

  Clock& clock_;
  emu::DatagramPort port_;
  Span bad_{};
  std::optional<netem::Impairment> impairment_;
  std::multimap<client::Time, std::vector<std::byte>> arrivals_;
  std::deque<std::vector<std::byte>> overheard_;
  std::vector<hal::Time> call_times_;  // of the first calls
};

}  // namespace stof::campaign

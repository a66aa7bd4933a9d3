#pragma once

#include <cstdint>
#include <optional>

#include "firmware/wire/packet.h"

namespace stof::bridge {

// When exposures were, by this machine's clock, of a sensor whose clock is synchronised with
// nothing. The sensor says how long after the middle of the exposure it sent the frame's first
// packet; arrival less that and the stamp is the difference of the clocks and the way. The smallest
// of the session, as the clocks may have drifted since, is taken for the difference: so a packet
// that was held back moves no stamp, and a stamp is too late by the way of the fastest packet,
// never too early. That way is no longer than the shortest round trip, which bounds the error.
//
// An emulated rig's time, or a recording's, runs as it likes: there the arrival less what the
// sensor says is all that is known, without a bound. No clock: times are the caller's, in ns of
// one clock that does not step.
class ExposureClock {
 public:
  static constexpr std::int64_t kDriftPpm = 200;  // of two quartz clocks, 100 each
  // Where all arrivals of so long are later than expected by more than kStep, the sensor's clock
  // stood (its machine was paused): the difference begins anew.
  static constexpr std::int64_t kStepNs = 100'000'000;
  static constexpr std::int64_t kPatienceNs = 1'000'000'000;

  struct Arrival {
    std::uint32_t session = 0;
    wire::FrameStamp stamp{};
    std::optional<std::int64_t> latency_ns{};  // FrameInfo::latency_ns; none: did not arrive
    std::int64_t at_ns = 0;                    // the frame's first packet
    std::optional<std::int64_t> round_trip_ns{};
  };
  struct Exposure {
    std::int64_t middle_ns = 0;  // by the clock of arrivals
    // The true middle lies in [middle - bound, middle]; none: not known.
    std::optional<std::int64_t> bound_ns{};
  };

  // Any numbers.
  Exposure note(const Arrival& arrival) noexcept;

 private:
  struct Least {
    std::int64_t difference_ns;
    std::int64_t at_ns;
  };

  std::int64_t drift_since(std::int64_t at_ns) const noexcept;
  void note_difference(std::int64_t difference_ns, std::int64_t at_ns) noexcept;

  std::optional<std::uint32_t> session_;
  std::optional<Least> least_;
  std::optional<std::int64_t> late_since_ns_;
  std::int64_t latency_ns_ = 0;  // the newest that is known
};

}  // namespace stof::bridge

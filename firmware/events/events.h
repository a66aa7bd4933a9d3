#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dsp/base/status.h"
#include "firmware/events/event_values.h"
#include "firmware/spsc_ring.h"
#include "firmware/wire/messages/enums.h"
#include "hal/time.h"

// The loop's reports: typed events in a fixed ring and plain counters. Text is made
// elsewhere.
namespace stof::firmware {

enum class Component : std::uint8_t { kTrigger, kStereo, kPmd, kLink, kLoop };
inline constexpr std::size_t kComponents = 5;

// State changes only: one event when a state begins, none while it lasts.
enum class EventKind : std::uint8_t {
  kPublishing,  // value: edges without a frame since the last one that had a frame
  kUnpaired,  // several edges in a row without a frame; component, status: what the last one missed
  kLost,      // component: its device is gone
  kBack,      // component: its device answers again
  kSendFailed,  // datagrams do not leave: nobody can be reached
  kSending,     // datagrams leave again
  kLate,        // value: whole periods that were skipped because the loop came too late
  kInTime,      // the loop has been in time for a while again
  kSilent,  // component: a camera that is there, and several edges in a row got nothing usable of
            // it
  kFrozen,  // the same, because it repeats what it sent; value: as of the condition
  kDark,    // the same, because its samples hold no light of its lamp
  kSupplying,  // component: edges have its frames again
  kStandsOn,   // value: Sensors that the last frames in a row stand on, other ones than before
  kSettingsChanged,  // value: who, as of the condition; former: kNetwork...; address
  kPairing,     // value, former: kPairing... of event_values.h; with digits role and address: what
                // is asked for
  kKeyMade,     // value: its id; role; address: whose
  kKeyRenewed,  // the same
  kKeyEnded,    // the same
  kLastKeyEnded,        // the same: the sensor is unpaired
  kCalibrationChanged,  // value: fingerprint of the new one; former: of the one before; address
  kStandby,             // value: 1: it begins, 0: it has ended
  kRelease,             // value: kRelease...; former: fingerprint of the release
};

struct Event {
  hal::Time at{};
  EventKind kind = EventKind::kPublishing;
  Component component = Component::kLoop;
  Status status = Status::kOk;
  std::uint32_t value = 0;
  std::uint32_t former = 0;
  wire::Role role = wire::Role::kNone;
  std::array<std::uint8_t, 16> address{};  // as in hal::Peer; all 0: not over the network
};

// Who, as conditions have it: the last four bytes of an address; 0: nobody of the network, which no
// address is.
constexpr std::uint32_t who(const std::array<std::uint8_t, 16>& address) noexcept {
  std::uint32_t last = 0;
  for (std::size_t i = 12; i < address.size(); ++i) {
    last = last << 8U | address[i];
  }
  return last == 0 && address != std::array<std::uint8_t, 16>{} ? 0xFFFF'FFFF : last;
}

// What clients changed, from the control thread to the loop's, which tells each. `at` is the
// loop's.
using ChangeRing = SpscRing<Event, 64>;

// Why a frame was not used. kNone: it was.
enum class Drop : std::uint8_t {
  kNone,
  kOlderEdge,    // left over from an edge that has passed
  kNewerEdge,    // begins after the window of this edge
  kTorn,         // its parts belong to different exposures
  kBadStamp,     // ends before it begins, or later than this exposure can
  kStale,        // its sequence number does not advance, or its pixels are those of before
  kWrongSize,    // not the size of the calibration
  kUnpartnered,  // it was good, its partner never came
  kDark,         // of the PMD camera: no light of its lamp
};
inline constexpr std::size_t kDrops = 9;

enum class Stage : std::uint8_t { kMatch, kConvert, kFuse, kPublish };
inline constexpr std::size_t kStages = 4;

struct StageTime {
  hal::Duration total{};
  hal::Duration longest{};

  constexpr void add(hal::Duration took) noexcept {
    total += took;
    longest = longest > took ? longest : took;
  }
};

// Written by the loop's thread alone; others may read when the loop has ended.
struct Counters {
  std::uint64_t edges = 0;            // pulses that went out
  std::uint64_t published = 0;        // frames handed to the publisher
  std::uint64_t with_pair = 0;        // of these, on what the pair saw
  std::uint64_t with_pmd = 0;         // on what the PMD camera measured
  std::uint64_t expired = 0;          // frames that were too old when their turn came
  std::uint64_t unpaired_edges = 0;   // edges without a frame
  std::uint64_t skipped_periods = 0;  // no pulse: the loop came too late
  std::uint64_t late_edges = 0;       // pulses later than the tolerance, but in their period
  std::uint64_t lost_events = 0;      // did not fit the ring
  std::uint64_t packets_sent = 0;
  std::uint64_t packets_dropped = 0;  // full queue, unreachable receiver
  std::array<std::uint64_t, kComponents> timeouts{};
  std::array<std::uint64_t, kComponents> errors{};  // kDeviceError, kCorrupt and the like
  std::array<std::uint64_t, kComponents> losses{};  // kDeviceLost, each time it was returned
  std::array<std::uint64_t, kDrops> stereo_dropped{};
  std::array<std::uint64_t, kDrops> pmd_dropped{};
  std::array<StageTime, kStages> stages{};  // of the frames published

  constexpr StageTime& stage(Stage which) noexcept {
    return stages[static_cast<std::size_t>(which)];
  }
};

// The count of one component, or of one cause.
template <typename Counts, typename Which>
constexpr auto& of(Counts& counts, Which which) noexcept {
  return counts[static_cast<std::size_t>(which)];
}

// The loop's thread notes, one other thread takes. Neither blocks or allocates.
class Events {
 public:
  Counters counters;

  // A full ring keeps what it has: the event is counted as lost.
  void note(const Event& event) noexcept { counters.lost_events += ring_.push(event) ? 0U : 1U; }
  // The oldest event that was not taken yet.
  std::optional<Event> take() noexcept { return ring_.pop(); }

 private:
  SpscRing<Event, 64> ring_;
};

}  // namespace stof::firmware

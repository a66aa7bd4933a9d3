#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"
#include "host/client/frame/frame_slot.h"
#include "host/client/raw/raw_assembler.h"
#include "host/client/session/frame_sequence.h"
#include "host/client/session/health_book.h"
#include "host/client/session/lens_book.h"
#include "host/client/session/message_check.h"
#include "host/client/session/report_queue.h"

namespace stof::client {

// The outcome of a packet outside the frames.
enum class MessageOutcome : std::uint8_t {
  kTaken,  // also the repetition of an event, which is not delivered again
  kDuplicate,
  kLate,  // a newer one arrived before
  kContradicting,
  kImplausible,  // ahead of what any sensor can have counted, or else no sensor's
};

// The messages of one session beside its frames. `arrived`: when the packet did; never earlier than
// the one before. Each counter may advance as fast as the time that has passed, and a little more.
// Where what is known is wrong nevertheless, it is replaced: health as HealthBook says, events by
// one that is repeated, calibrations as LensBook says.
class SessionMessages {
 public:
  // most_raw_pixels: of a raw picture. units_change: as of LensBook.
  explicit SessionMessages(std::size_t most_raw_pixels = 0, bool units_change = false)
      : lenses_(units_change), raw_(most_raw_pixels) {}

  // A session begins. outlasts: what was learned of lenses (SessionTracker::outlasts()), which is
  // forgotten else. Health that nobody took stays. Returns the events that nobody took.
  std::size_t restart(bool outlasts);

  // frames: of the same session; a calibration tells the number of the frame it was sent beside.
  // period: that it tells, also where its lens is not believed; none: it is none of now.
  MessageOutcome push_calibration(const wire::PacketView& packet, const FrameSequence& frames,
                                  Time arrived, std::optional<Duration>& period);
  // A frame was closed, of which the last packet arrived then; made: nothing: its info did not.
  void note_frame(std::uint32_t number, const std::optional<MadeWith>& made, ImageSize depth,
                  Time arrived) noexcept;
  // Messages and frames, events, and raw pictures that contradict each other, and
  // HealthBook::lies(), over all sessions.
  std::uint64_t lies() const noexcept { return lies_ + health_.lies() + raw_.lies(); }
  // is_signed: by the sensor, for this receiver.
  MessageOutcome push_health(const wire::PacketView& packet, bool is_signed, Time arrived);
  // overflow: an older event was given up for it.
  MessageOutcome push_event(const wire::PacketView& packet, Time arrived, bool& overflow);

  // The clock of arrivals stood for so long.
  void slept(Duration time) noexcept { health_.slept(time); }

  // LensBook::current().
  const std::optional<wire::CalibrationPacket>& calibration() const noexcept {
    return calibration_;
  }
  const LensBook& lenses() const noexcept { return lenses_; }
  const std::optional<wire::HealthReport>& health() const noexcept { return health_.current(); }
  // When they arrived; only where there is one.
  Time calibration_at() const noexcept { return calibration_at_; }
  Time health_at() const noexcept { return health_.at(); }

  // In the order of arrival, each once; 64 events of this session are kept, and 16 reports of
  // health. A recording that is played repeats the same one.
  std::optional<ToldEvent> take_event() { return events_.take(); }
  std::optional<ToldHealth> take_health() { return healths_.take(); }

  RawAssembler& raw() noexcept { return raw_; }
  const RawAssembler& raw() const noexcept { return raw_; }

 private:
  static constexpr std::int32_t kWindow = 64;  // sequences of events that are told apart

  // A counter that was not believed.
  struct Refused {
    std::uint64_t value = 0;
    Time at;
  };

  bool seen(std::uint32_t sequence) const noexcept;
  bool repeats_refused_event(std::uint32_t sequence, Time arrived) noexcept;

  LensBook lenses_;
  MessageCheck beside_;
  std::optional<wire::CalibrationPacket> calibration_;
  std::uint64_t lies_ = 0;
  std::optional<std::uint32_t> calibration_frame_;  // of the newest message that was taken
  Time calibration_at_;
  HealthBook health_;
  std::optional<Refused> refused_event_;  // by its sequence
  ReportQueue<wire::EventReport, 64> events_;
  ReportQueue<wire::HealthReport, 16> healths_;
  bool event_seen_ = false;
  std::uint32_t newest_event_ = 0;                      // sequence
  std::uint64_t older_events_ = 0;                      // bit k: sequence newest_event_ - k arrived
  std::array<wire::EventReport, kWindow> events_seen_;  // these, by their sequence
  RawAssembler raw_;
};

}  // namespace stof::client

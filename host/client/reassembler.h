#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "firmware/wire/packet.h"
#include "host/client/frame/closed_frames.h"
#include "host/client/frame/frame.h"
#include "host/client/frame/frame_slot.h"
#include "host/client/reassembler_options.h"
#include "host/client/session/frame_delay.h"
#include "host/client/session/frame_pace.h"
#include "host/client/session/frame_sequence.h"
#include "host/client/session/session_messages.h"
#include "host/client/session/session_tracker.h"
#include "host/client/session/stream_verifier.h"
#include "host/client/statistics.h"

namespace stof::client {

// Datagrams in, frames out, in the order of their numbers. Two frames are in flight: packets of
// frame n and n + 1 may be mixed in any order. Frame n is closed and delivered
//  - when all its packets are there,
//  - when a later frame is complete (all that is missing would have to arrive after that), or
//  - when a packet of frame n + 2 or later arrives, or
//  - by expire().
// Where the sender adds parity, a part that is missing is made of the others and the group's parity
// packet as soon as these are there: it counts as recovered, and not as missing. Whether it does
// the frame's info says; where that is missing, the newest one: a parity packet proves nothing. A
// stream that was joined in the middle of a frame begins to be repaired with the next one.
//
// No clock and no socket: times are the caller's, and must not go back.
class Reassembler {
 public:
  explicit Reassembler(const ReassemblerOptions& options = {});

  // Any bytes, that arrived then and are read now. take() until it returns nothing before the next
  // push(): there is room for what one datagram can finish; older frames are dropped, and counted,
  // when more is needed.
  void push(std::span<const std::byte> datagram, Time arrived, Time now);
  // Read when it arrived.
  void push(std::span<const std::byte> datagram, Time now) { push(datagram, now, now); }

  // The sensor said in an answer that it is this one: no other session is believed any more
  // (SessionTracker).
  void expect(const wire::Origin& sensor) noexcept { session_.expect(sensor); }

  // Closes the frames that waited too long. To be called when nothing is left to push.
  void expire(Time now);
  // When expire() will have something to do.
  std::optional<Time> next_expiry() const;

  // The next finished frame, valid until the next take(). With a time: of those that are not too
  // old.
  std::optional<Frame> take();
  std::optional<Frame> take(Time now);
  // Moves the images of the last frame to `pixels`, for whose memory it is valid; reuses theirs.
  bool keep(FramePixels& pixels) noexcept;  // once a frame; false: none is out

  const Statistics& statistics() const noexcept { return statistics_; }
  // Datagrams that no sensor can have sent, sessions beside the sensor's, packets that contradict
  // others of their frame, and starts of the order of frames anew; what is not signed only once
  // there is a key.
  std::uint64_t forgeries() const noexcept {
    return forgeries_ + (is_signed() ? 0 : messages_.lies()) + session_.contests();
  }
  // Frames that came too late, by their stamps.
  std::uint64_t late_frames() const noexcept { return late_frames_; }
  FrameDelay& delay() noexcept { return delay_; }
  // For how long this machine has slept since its start: the clock of arrivals stood, the sensor's
  // counters did not.
  void slept(Duration total) noexcept {
    const Duration more = total - delay_.slept();
    sequence_.slept(more);
    messages_.slept(more);
    delay_.slept(total);
  }
  // Of the sensor's trigger, as it tells and frames come (FramePace), where it is signed as it
  // tells; 0: not known.
  Duration period() const;
  // Of the current session; none: nothing was heard.
  const std::optional<wire::Origin>& origin() const noexcept { return session_.current(); }
  // The newest of the current session.
  const std::optional<wire::CalibrationPacket>& calibration() const noexcept {
    return messages_.calibration();
  }
  const std::optional<wire::HealthReport>& health() const noexcept { return messages_.health(); }
  // The same with their times of arrival.
  const SessionMessages& messages() const noexcept { return messages_; }

  // Conditions that began or ended, and what health() was: as SessionMessages says.
  std::optional<ToldEvent> take_event() { return messages_.take_event(); }
  std::optional<ToldHealth> take_health() { return messages_.take_health(); }
  // Where they were asked for, however old they are.
  RawAssembler& raw() noexcept { return messages_.raw(); }

 private:
  static constexpr std::size_t kSlots = 4;  // two open, two finished or one finished and one out

  // Nobody else can have sent what is used.
  bool is_signed() const noexcept { return options_.verifier != nullptr; }
  // Whether a datagram that was parsed may be believed; counts it where not.
  bool verify(std::span<const std::byte> datagram, std::uint32_t session);
  void start_session();
  void push_report(const wire::PacketView& packet, Time arrived);
  void push_calibration(const wire::PacketView& packet, Time arrived);
  void push_part(const wire::PacketView& packet, Time arrived);
  void push_parity(const wire::PacketView& packet, Time arrived);
  void refuse_old(const wire::Header& header, Time arrived);
  FrameSequence::Verdict judge(const wire::Header& header, Time arrived);
  void count(MessageOutcome outcome);
  bool count(Placed placed);  // whether something was added
  bool comes_late(const FrameSlot& slot);
  void refuse_closed(const wire::PacketView& packet);
  void count_closed_parity(const wire::PacketView& packet);
  void note_info(FrameSlot& slot, Time now);
  void repair(FrameSlot& slot, std::size_t group, Time now);
  void close_if_complete(FrameSlot& slot);
  FrameSlot& open(const wire::Header& header, Time now);
  void close(FrameSlot& slot);
  void close_older_than(std::uint32_t number);
  void drop(FrameSlot& slot, std::uint64_t Statistics::* cause);
  void drop_open();
  FrameSlot* oldest(FrameSlot::State state);
  Duration frame_timeout() const;
  Duration assumed_period() const;
  Duration max_age() const;

  ReassemblerOptions options_;
  Statistics statistics_;
  std::uint64_t forgeries_ = 0;
  std::uint64_t late_frames_ = 0;
  std::array<FrameSlot, kSlots> slots_;
  std::uint64_t finished_ = 0;  // frames, over all sessions

  SessionTracker session_;
  FramePace pace_;  // of all sessions
  // The state of the session.
  FrameSequence sequence_;
  FrameDelay delay_;
  bool parity_ = false;  // the newest frame info says so
  SessionMessages messages_;
  ClosedFrames closed_;
};

}  // namespace stof::client

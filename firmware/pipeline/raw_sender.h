#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dsp/base/status.h"
#include "firmware/pipeline/shot.h"
#include "firmware/wire/datagram_sink.h"
#include "firmware/wire/frame/raw_packets.h"
#include "firmware/wire/packet.h"
#include "hal/clock.h"

namespace stof::firmware {

// Sends what the cameras gave for an exposure to the one receiver that asked for it, in the time
// that frames leave: see "Raw pictures" of docs/WIRE.md.
//
// It keeps the slots that the cameras lent, of one exposure at a time, until its last packet has
// left or a second has passed: there is no copy of a picture, and a camera whose frames the loop
// holds as well can still fill a third. What is due while one is on its way, and what is given up,
// is counted and told with the next exposure. No heap; for the loop's thread.
class RawSender {
 public:
  static constexpr std::size_t kBurst = 8;  // packets that are handed over at once
  // Between two bursts: all of them stay below 640 Mbit/s, and what they fill empties meanwhile.
  static constexpr hal::Duration kGap = std::chrono::microseconds(125);
  // Of a full queue, then after twice as long each time that it takes nothing: then others fill the
  // link, and what it is not given here it has time for.
  static constexpr hal::Duration kRetry = std::chrono::microseconds(500);
  static constexpr hal::Duration kMostRetry = std::chrono::milliseconds(16);
  // A burst begins no later than this before the next packet of a frame, or the next edge.
  static constexpr hal::Duration kMargin = std::chrono::microseconds(150);
  static constexpr hal::Duration kMostSpread = std::chrono::milliseconds(200);
  static constexpr hal::Duration kGiveUp = std::chrono::seconds(1);

  // To the receiver.
  class Way {
   public:
    virtual ~Way() = default;
    // Without blocking, at most kBurst; how many were taken, the first ones. kOk: all of them.
    // kWouldBlock: the next ones later. Else: the receiver cannot be reached.
    virtual Status send_raw(wire::Datagrams datagrams, std::size_t& sent) noexcept = 0;
  };

  RawSender(const wire::Origin& origin, hal::Clock& clock) noexcept
      : origin_(origin), clock_(clock) {}

  // From now on, with counts that begin anew; pictures 0: nobody wants any.
  void ask(const wire::RawRequest& request) noexcept;
  void set_period(hal::Duration period) noexcept { period_ = period; }
  // Told with each exposure.
  void set_search(int pmd_every, int disparities) noexcept {
    pmd_every_ = static_cast<std::uint8_t>(pmd_every);
    disparities_ = static_cast<std::uint16_t>(disparities);
  }

  // A frame was made of `shot` and sent, and nobody needs the shot any more: takes the frames of
  // the cameras out of it where its pictures are to be sent.
  void offer(Shot& shot, const wire::FrameStamp& stamp) noexcept;
  // Sends what is due, for as long as the time up to `until` allows, and waits between bursts.
  // Returns before `until`, or at once where it has passed.
  void send_until(hal::Time until, Way& way) noexcept;
  // As send_until(), but spread over no more time than the link wants: another exposure is due.
  void hurry(hal::Time until, Way& way) noexcept {
    hurries_ = wait_ == 0;
    if (hurries_) {
      send_until(until, way);
    }
  }
  // The slots of these cameras go home now: they are to be opened again, or nobody exposes any
  // more. The pictures of an exposure go together.
  void give_back(bool pair, bool samples) noexcept;

  // Exposures of this request that were due and not sent, or not to their end.
  std::uint32_t dropped() const noexcept { return dropped_; }

 private:
  bool underway() const noexcept { return next_ < packets_.count(); }
  void begin(Shot& shot, std::uint8_t pictures, const wire::FrameStamp& stamp) noexcept;
  hal::Time burst_due() const noexcept;
  void send_burst(Way& way) noexcept;
  void give_up() noexcept;
  void lose() noexcept;
  void release() noexcept;

  wire::Origin origin_;
  hal::Clock& clock_;
  wire::RawRequest request_{};
  hal::Duration period_{};
  std::uint8_t pmd_every_ = 1;
  std::uint16_t disparities_ = 0;
  std::uint32_t wait_ = 0;    // frames before the next exposure is due
  std::uint32_t number_ = 0;  // exposures that were begun
  std::uint32_t dropped_ = 0;
  std::uint8_t state_ = 0;       // of the shots since the last exposure that was begun
  std::uint8_t told_state_ = 0;  // with the exposure on its way
  // The exposure on its way.
  std::optional<hal::BorrowedFrame<hal::StereoFrame>> stereo_;
  std::optional<hal::BorrowedFrame<hal::PmdFrame>> pmd_;
  wire::RawPackets packets_;
  std::size_t next_ = 0;
  hal::Time start_{};
  hal::Time not_before_{};  // the next burst
  bool hurries_ = false;
  hal::Duration retry_ = kRetry;
  std::array<wire::DatagramBuffer, kBurst> buffers_{};
};

}  // namespace stof::firmware

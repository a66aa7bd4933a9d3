#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>

#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"
#include "host/client/frame/frame_slot.h"

namespace stof::client {

// The order of a session's frames, and how far their numbers and freshness may jump: a sensor
// counts at most one frame a millisecond, and 128 more are let pass. So one packet that says
// anything else, forged or of a faulty sensor, cannot make the frames that follow look old. Where
// what is known is wrong nevertheless, because the first packet was the forged one, it is forgotten
// after a second without a fresh frame, for a stream whose numbers and freshness both advance:
// what repeats itself is never taken for new.
// Two senders count where a packet comes of a frame that was made of others, and where three frames
// come within five seconds, or eight numbers, that were passed over: half a second ago or more, for
// bad networks bring all packets of a small frame behind those of newer ones.
class FrameSequence {
 public:
  static constexpr Duration kPatience = std::chrono::seconds(1);

  enum class Verdict : std::uint8_t {
    kBelieved,        // of a frame that is open or may begin
    kOver,            // its frame was closed
    kPassedOver,      // likewise, without a packet of it: two senders count
    kImplausible,     // too far ahead
    kResynchronised,  // believed: what was known of the order is forgotten
  };

  // The clock of arrivals stood for so long.
  void slept(Duration time) noexcept {
    newest_at_ -= time;
    fresh_at_ = fresh_at_ ? std::optional(*fresh_at_ - time) : std::nullopt;
  }

  // Of a packet of a frame that arrived then.
  Verdict judge(const wire::FrameStamp& stamp, Time arrived) noexcept;
  // Whether a frame number may be told then; any before the first frame.
  bool plausible(std::uint32_t number, Time arrived) const noexcept;
  // Whether no packet of this frame, nor of a newer one, was used yet, but of one before.
  bool ahead(std::uint32_t number) const noexcept;

  // A packet of this frame is used; true: no newer frame was seen before.
  bool begin(std::uint32_t number, Time arrived) noexcept;
  // The frame, newer than all that were closed, gets no more packets: how many numbers before it
  // were never seen.
  std::uint32_t close(std::uint32_t number) noexcept;
  // It was closed without a part of it, with parity alone: newer ones have passed it over.
  void pass(std::uint32_t number, Time now) noexcept {
    begun_.reset(number % kRemembered);
    passed_at_[number % kRemembered] = now;
  }
  // A packet that it was made of.
  void remember(const PacketMark& mark) noexcept { marks_[mark.number % kRemembered] = mark; }
  // Whether a packet of a frame that is over has another sender than the frame.
  bool contradicts(const wire::PacketView& packet) const noexcept {
    return marks_[packet.header.frame.number % kRemembered].contradicts(packet);
  }
  // Whether a closed frame shows a newer exposure than every one before; it counts from now on.
  bool advance(std::uint32_t freshness, Time arrived) noexcept;

 private:
  // What packets told of themselves, believed or not, since a fresh frame.
  struct Trail {
    std::uint32_t number = 0;
    std::uint32_t freshness = 0;
    int advances = 0;
  };

  // Frames that were passed over and came after all, since then; each with a higher number.
  struct Passed {
    std::uint32_t first = 0;   // its number
    std::uint32_t number = 0;  // of the newest
    Time since{};
    int frames = 0;
  };
  static constexpr std::uint32_t kRemembered = 256;
  static constexpr Duration kSpread = 2 * kTurnedRound;

  bool over(std::uint32_t number) const noexcept;
  // A packet came of a frame that is over: whether it belongs to a second sender.
  bool passed_over(std::uint32_t number, Time arrived) noexcept;
  bool fresh(std::uint32_t freshness) const noexcept;
  void follow(const wire::FrameStamp& stamp) noexcept;

  std::optional<std::uint32_t> newest_;  // number of a frame that was begun
  Time newest_at_;
  std::optional<std::uint32_t> closed_;     // number of the newest closed frame
  std::optional<std::uint32_t> freshness_;  // of the newest fresh frame
  std::optional<Time> fresh_at_;            // when it arrived; before the first: when we began
  std::optional<Trail> trail_;
  std::bitset<kRemembered> begun_;             // of the newest numbers, by their remainder
  std::array<Time, kRemembered> passed_at_{};  // likewise: when newer ones came before it
  std::array<PacketMark, kRemembered> marks_;  // likewise
  std::optional<Passed> passed_;
};

}  // namespace stof::client

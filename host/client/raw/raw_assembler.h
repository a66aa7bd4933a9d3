#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/wire/packet.h"
#include "host/client/frame/arrival_mask.h"
#include "host/client/frame/frame_slot.h"
#include "host/client/raw/raw_exposure.h"

namespace stof::client {

// What became of a packet of raw pictures.
enum class RawOutcome : std::uint8_t {
  kTaken,
  kUnknown,  // a stream or codec of a newer sensor, or nobody asked for it
  kDuplicate,
  kContradicting,  // itself, or others of its exposure: lies() counts the latter
  kLate,           // its exposure was finished already
  kOversized,
};

// Raw pictures of one session put together: two exposures may be on their way. One is finished when
// all its packets are there, when a later one is, when a third begins, or when nothing came for
// kTimeout. Memory grows with the pictures, up to 7 bytes a pixel of each of five exposures, and is
// kept. No clock: times are the caller's, and must not go back.
class RawAssembler {
 public:
  static constexpr Duration kTimeout = std::chrono::seconds(2);

  // most_pixels: of a picture; 0: nobody asked for any, all are unknown.
  explicit RawAssembler(std::size_t most_pixels) : most_pixels_(most_pixels) {}

  // Verified, of the session, of type kRawInfo or kRawTile.
  RawOutcome push(const wire::PacketView& packet, Time arrived);
  void expire(Time now);
  std::optional<Time> next_expiry() const;
  // Another session begins.
  void restart();

  // The next that is finished, valid until the next take(); two are kept.
  std::optional<RawExposure> take();
  const RawStatistics& statistics() const noexcept { return statistics_; }
  // Packets that contradict others of their exposure, over all sessions: the network repeats
  // exactly, so two have sent them.
  std::uint64_t lies() const noexcept { return lies_; }

 private:
  static constexpr std::size_t kOpen = 2;
  static constexpr std::size_t kSlots = kOpen + 3;  // two finished, and one that is out
  static constexpr std::size_t kClosed = 256;       // whose packets are still known as late

  // Bytes of a pixel: 1 or 2.
  struct Picture {
    ArrivalMask mask;
    std::size_t pixels = 0;  // that arrived
    std::vector<std::uint8_t> bytes;
    std::vector<std::uint16_t> words;

    void begin();
    bool whole(int width, int height) const noexcept;
  };
  enum class State : std::uint8_t { kFree, kOpen, kFinished, kOut };
  struct Slot {
    State state = State::kFree;
    std::uint64_t order = 0;  // of beginning
    wire::Header header{};    // of one of its packets
    PacketSet packets;
    std::size_t arrived = 0;
    std::optional<wire::RawInfo> info;
    std::array<Picture, 3> pictures;
    Time last{};
  };

  // Of an exposure that is over.
  struct Closed {
    wire::FrameStamp stamp{};
    PacketMark mark{};
  };

  // Whether its exposure has packets of another sender.
  bool contradicts(const wire::PacketView& packet) const noexcept;
  Slot* slot_of(const wire::Header& header, Time arrived);
  static RawOutcome place(Slot& slot, const wire::PacketView& packet);
  void finish(Slot& slot);
  void finish_up_to(std::uint64_t order);
  void count(const wire::RawInfo& info);
  Slot* oldest(State state);
  static RawExposure view(const Slot& slot);

  std::size_t most_pixels_;
  std::array<Slot, kSlots> slots_;
  std::uint64_t begun_ = 0;
  std::vector<Closed> closed_;  // the newest kClosed, in a ring
  std::size_t closed_count_ = 0;
  std::uint32_t number_ = 0;   // of the newest that was finished with its info; 0: none yet
  std::uint32_t dropped_ = 0;  // as it told
  RawStatistics statistics_;
  std::uint64_t lies_ = 0;
};

}  // namespace stof::client

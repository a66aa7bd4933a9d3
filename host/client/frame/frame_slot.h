#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/wire/frame/parity.h"
#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"
#include "host/client/frame/frame_pixels.h"
#include "host/client/frame/made_with.h"
#include "host/client/session/lens_book.h"

namespace stof::client {

// How the numbers of frames compare when they wrap: negative, 0 or positive as a is before, at or
// after b.
constexpr std::int32_t number_distance(std::uint32_t a, std::uint32_t b) noexcept {
  return static_cast<std::int32_t>(a - b);
}

// One packet of a frame, by which its sender is known again: the network repeats it bit for bit.
struct PacketMark {
  std::uint32_t number = 0;  // of the frame
  std::uint16_t count = 0;   // of its packets; 0: nothing is known of any
  std::uint16_t index = 0;
  std::uint32_t crc = 0;

  // Whether this one comes under the frame's number, and is another sender's.
  bool contradicts(const wire::PacketView& packet) const noexcept;
};

// Which packets of a frame arrived.
class PacketSet {
 public:
  void begin(std::size_t count);
  bool has(std::size_t index) const noexcept;  // false beyond the end
  // One that arrived, or that parity made, at an index below the count.
  void insert(std::size_t index, const wire::PacketView& packet) noexcept;
  // Whether that one has other bytes: networks repeat exactly, so two have sent it.
  bool differs(std::size_t index, const wire::PacketView& packet) const noexcept;
  // Of the frame of this number: one of these, in each frame another one.
  PacketMark mark(std::uint32_t number) const noexcept;

 private:
  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> crcs_;
};

// One frame being put together. Keeps its memory from frame to frame.
class FrameSlot {
 public:
  enum class State : std::uint8_t { kFree, kOpen, kFinished, kOut };

  State state = State::kFree;
  std::uint64_t order = 0;  // of finishing

  // Forgets what was here before. header: of one of the frame's parts. parity: the sender uses it,
  // so that sums are kept from the first part on.
  void begin(const wire::Header& header, bool parity, Time now);

  // part: of this frame's number and session; a tile is consistent_tile() or of unknown kind.
  Placed add(const wire::PacketView& part, Time now);
  Placed add_parity(const wire::PacketView& packet, Time now);

  // The part that this group's parity makes good, if exactly one is missing; to be checked and
  // added as one that arrived. Valid until the next begin().
  std::optional<wire::PacketView> recover(std::size_t group) const;
  void count_recovered() noexcept { ++recovered_; }
  // Whether sums are kept, and of what group a part is. Only then.
  bool parity() const noexcept { return !groups_.empty(); }
  std::size_t group_of(std::size_t index) const noexcept { return index % groups_.size(); }
  std::size_t parity_sums() const noexcept { return groups_.size(); }
  // Whether parity of a group goes with this frame: as its info says; before that came, as `told`.
  bool has_parity(std::size_t group, bool told) const noexcept;
  bool told_no_parity() const noexcept { return info_ && info_->parity_groups == 0; }
  // Its info says that there is none: what came of it is forgotten; true: something did.
  bool drop_false_parity();

  // Makes none of every pixel that did not arrive; before view().
  void finish() { pixels_.finish(); }
  Frame view() const;
  // After view(): its images are those of `pixels` from now on, and their memory becomes this
  // slot's.
  void swap_pixels(FramePixels& pixels) noexcept { std::swap(pixels_, pixels); }

  bool complete() const noexcept { return received_packets_ == header_.count; }
  std::uint32_t missing_packets() const noexcept { return header_.count - received_packets_; }
  std::uint16_t count() const noexcept { return header_.count; }
  const wire::FrameStamp& stamp() const noexcept { return header_.frame; }
  std::uint32_t number() const noexcept { return header_.frame.number; }
  std::uint32_t freshness() const noexcept { return header_.frame.freshness; }
  Time last_packet() const noexcept { return last_packet_; }
  const PacketSet& packets() const noexcept { return packets_; }
  const PacketSet& parity_packets() const noexcept { return parity_packets_; }
  // Nothing: that packet did not arrive.
  std::optional<MadeWith> made_with() const noexcept {
    return info_ ? std::optional(client::made_with(header_.origin.session_id, *info_))
                 : std::nullopt;
  }
  // Zeros: it has none, or nothing of it arrived.
  ImageSize depth_size() const;
  // Of those that were told by now, once the frame is finished.
  void choose_calibration(const LensBook& told);

 private:
  bool agrees(const wire::FrameStamp& stamp) const noexcept;
  Placed add_info(const wire::PacketView& part);
  void begin_parity();

  wire::Header header_;  // of the part that came first
  Time first_packet_;
  Time last_packet_;
  std::uint32_t received_packets_ = 0;
  std::uint32_t recovered_ = 0;
  PacketSet packets_;
  PacketSet parity_packets_;
  std::size_t parity_arrived_ = 0;
  std::vector<wire::ParityGroup> groups_;  // empty: no sums are kept
  FramePixels pixels_;
  std::optional<wire::FrameInfo> info_;
  std::optional<wire::CalibrationPacket> calibration_;
};

}  // namespace stof::client

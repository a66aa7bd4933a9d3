#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "firmware/wire/messages/parity.h"
#include "firmware/wire/messages/stream_signature.h"
#include "firmware/wire/packet.h"

// One lost packet of a group of at most 16 comes back from the exclusive or of the others and the
// group's parity packet: docs/WIRE.md, "Parity".
namespace stof::wire {

// The longest payload of a part that takes part in parity.
inline constexpr std::size_t kMaxParityData = kMaxPayload - kParityFieldsBytes;
// The bound of every part of a frame that is sent, so that parity and signatures can be switched on
// at any time.
inline constexpr std::size_t kMaxTilePayload = kMaxParityData - kStreamSignatureBytes;

inline constexpr std::uint16_t kParityGroupSize = 16;

// In a frame of `count` packets, packet i belongs to group i mod parity_groups(count), so that a
// burst of losses hits different groups.
constexpr std::uint16_t parity_groups(std::uint16_t count) noexcept {
  return static_cast<std::uint16_t>((count + kParityGroupSize - 1) / kParityGroupSize);
}
// Packets of a group; group < parity_groups(count).
constexpr std::uint16_t parity_members(std::uint16_t count, std::uint16_t group) noexcept {
  const int groups = parity_groups(count);
  return static_cast<std::uint16_t>((count - group + groups - 1) / groups);
}

// The exclusive or of what of a group was added. Trivially copyable; no heap.
class ParityGroup {
 public:
  void clear() noexcept { *this = {}; }

  // A part of the frame, each at most once: the caller knows which ones arrived. kTooLarge: a
  // payload above kMaxParityData, nothing is added; no sender with parity makes such a part.
  Status add(const Header& header, std::span<const std::byte> payload) noexcept;

  // The group's parity packet, once. kCorrupt: not a parity packet, or its index, count or fields
  // contradict each other; nothing is added.
  Status add_parity(const PacketView& packet) noexcept;

  // Whether the parity packet and all members but one were added.
  bool one_is_missing() const noexcept;

  // That one, as parse_packet() would have told it; the payload lies in this object. Origin and
  // stamp are those of the parity packet. kInvalidArgument: not one_is_missing(). kCorrupt: what
  // was added is not of one frame.
  Result<PacketView> recover() const& noexcept;
  Result<PacketView> recover() const&& = delete;

  // Sender: the payload of the parity packet; at most kMaxPayload bytes. Header of that packet:
  // type parity, index: the group, count: parity_groups(frame_count), stamp and image size of the
  // frame.
  std::size_t write(std::uint16_t frame_count,
                    std::span<std::byte, kMaxPayload> out) const noexcept;

 private:
  void add_bytes(std::span<const std::byte> payload) noexcept;

  ParityFields sum_{};  // without `count`
  std::uint16_t index_sum_ = 0;
  std::uint16_t members_ = 0;      // added
  std::uint16_t longest_ = 0;      // payload, bytes
  std::uint16_t frame_count_ = 0;  // as the parity packet says; 0: it was not added
  Header parity_{};                // of that packet
  std::array<std::byte, kMaxParityData> bytes_{};
};

}  // namespace stof::wire

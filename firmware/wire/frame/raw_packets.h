#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/image.h"
#include "firmware/wire/messages/raw_info.h"
#include "firmware/wire/packet.h"

// What the cameras gave for one exposure as packets: see "Raw pictures" of docs/WIRE.md.
namespace stof::wire {

// Of RawRequest and RawInfo, bits of `pictures`.
inline constexpr std::uint8_t kRawLeft = 1;
inline constexpr std::uint8_t kRawRight = 2;
inline constexpr std::uint8_t kRawPmd = 4;
inline constexpr std::uint8_t kRawPictures = kRawLeft | kRawRight | kRawPmd;
inline constexpr std::uint8_t kRawWhole = 8;  // only exposures that have all that is asked for
inline constexpr std::uint8_t kRawAnew = 16;  // the sensor begins anew what counts between frames
// Bits of RawInfo::state, since the exposure that was sent before.
inline constexpr std::uint8_t kRawBegunAnew = 1;   // all that counts from frame to frame
inline constexpr std::uint8_t kRawForgotPast = 2;  // depth was averaged with no frame before

inline constexpr std::size_t kRawSamples = 4;
// With a signature it fits a datagram.
inline constexpr std::size_t kMaxRawPayload = 1148;

// As the cameras lent them, of any size; empty: not there, or not to be sent.
struct RawImages {
  dsp::ImageView<const std::uint8_t> left;
  dsp::ImageView<const std::uint8_t> right;                              // of the left one's size
  std::array<dsp::ImageView<const std::uint16_t>, kRawSamples> samples;  // of equal size
};

// One exposure's packets, each made when it is asked for, of the pictures where they lie: there is
// no copy of them. Views: the pictures outlive it. No heap.
class RawPackets {
 public:
  // Nothing to send: count() is 0.
  RawPackets() = default;
  // Of the pair the part that `request` names, as far as it lies in the pictures. info: what is
  // known of the exposure; sizes, pictures and step are filled in here.
  RawPackets(const Origin& origin, const FrameStamp& stamp, const RawImages& images,
             const RawRequest& request, const RawInfo& info) noexcept;

  // At most 65,535: else there is nothing to send.
  std::size_t count() const noexcept { return count_; }
  // Packet `index` below count(), sealed in `buffer`; part of it.
  std::span<const std::byte> seal(std::size_t index, DatagramBuffer& buffer) const noexcept;

 private:
  struct Tile {
    std::size_t index = 0;   // of its picture
    std::size_t packet = 0;  // of them all
  };
  std::span<const std::byte> seal_info(DatagramBuffer& buffer) const noexcept;
  std::span<const std::byte> seal_pair(Stream stream, const Tile& place,
                                       DatagramBuffer& buffer) const noexcept;
  std::span<const std::byte> seal_pmd(const Tile& place, DatagramBuffer& buffer) const noexcept;
  Header header(PacketType type, std::size_t index) const noexcept;
  std::size_t tiles_of_eye() const noexcept;
  std::size_t tiles_of_pmd() const noexcept;

  Origin origin_{};
  FrameStamp stamp_{};
  RawImages images_{};
  RawInfo info_{};
  std::size_t count_ = 0;
};

// Whether a raw tile has a known stream, its codec, and as many pixels as it says, within its
// picture.
bool consistent_raw_tile(const PacketView& packet) noexcept;

}  // namespace stof::wire

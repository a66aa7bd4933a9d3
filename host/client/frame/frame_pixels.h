#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/base/fixed.h"
#include "firmware/wire/packet.h"
#include "host/client/frame/arrival_mask.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// The outcome of one packet in its frame.
enum class Placed : std::uint8_t {
  kStored,
  kIgnored,  // of a newer kind; counted for completeness, nothing to keep
  kDuplicate,
  kContradicting,  // itself, or the frame's other packets, or its pixels are there already
};

// The images of one frame being put together. Memory is asked for the streams that arrive, and kept
// from frame to frame: until finish() pixels without a mark are whatever was there before.
class FramePixels {
 public:
  void begin() noexcept;

  // Takes frame info: which streams were sent, and the size of the depth image. False: that is not
  // the one of the tiles.
  bool expect(const wire::Header& header, const wire::FrameInfo& info);

  // A tile that is consistent_tile() or of an unknown kind. Never kDuplicate.
  Placed add(const wire::PacketView& tile);

  // Makes none of every pixel that did not arrive. Nothing may be added after it.
  void finish();

  // After finish(): fills in images, marks and missing pixels. Valid until the next begin().
  void view(Frame& frame) const;

 private:
  static constexpr std::size_t kMasks = 6;  // depth, width and source share one

  struct Layer {
    std::uint32_t received = 0;  // pixels
    bool sent = false;           // says frame info
  };

  static std::size_t mask_index_of(wire::Stream stream) noexcept;
  const ArrivalMask& mask(wire::Stream stream) const noexcept {
    return masks_[mask_index_of(stream)];
  }
  bool present(wire::Stream stream) const noexcept;
  bool decode(const wire::PacketView& tile, std::size_t first, std::size_t pixels);
  bool decode_source(const wire::PacketView& tile, std::size_t first, std::size_t pixels);
  bool decode_disparity(const wire::PacketView& tile, std::size_t first, std::size_t pixels);
  template <typename T>
  void finish(wire::Stream stream, std::vector<T>& image, const T& none);
  template <typename T>
  dsp::ImageView<const T> image(wire::Stream stream, const std::vector<T>& pixels) const noexcept;

  std::array<ArrivalMask, kMasks> masks_;
  std::array<Layer, kStreams> layers_;
  std::vector<dsp::QuarterMm> depth_;
  std::vector<dsp::QuarterMm> width_;
  std::vector<dsp::Source> source_;
  std::vector<dsp::Cause> cause_;
  std::vector<dsp::Disparity> disparity_;
  std::vector<std::uint16_t> pmd_;
  std::vector<std::uint8_t> left_;
  std::vector<std::uint8_t> right_;
  std::vector<CloudPoint> cloud_;
  std::vector<std::uint8_t> bytes_;   // of one tile
  std::vector<std::uint16_t> words_;  // of one tile
};

}  // namespace stof::client

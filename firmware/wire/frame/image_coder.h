#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "firmware/wire/frame/frame_images.h"
#include "firmware/wire/frame/part_store.h"
#include "firmware/wire/frame/tiles.h"

namespace stof::wire {

// The images of one frame to tiles in a store. Choices for a stream when the frame is coded first
// (RVL would be longer than raw) hold until begin_frame(): coded again, a frame is the same.
class ImageCoder {
 public:
  ImageCoder(const FrameSizes& sizes, dsp::Arena& arena) noexcept;

  void begin_frame() noexcept;

  void add_map(const dsp::DepthMap& map, const StreamChoice& choice, PartStore& store) noexcept;
  void add_disparity(dsp::ImageView<const dsp::Disparity> image, Coding coding,
                     PartStore& store) noexcept;
  void add_pmd(const FrameImages& images, Coding coding, PartStore& store) noexcept;
  void add_grey(dsp::ImageView<const std::uint8_t> image, Stream stream, Coding coding,
                PartStore& store) noexcept;

 private:
  // How depth or width is rounded.
  struct Rounding {
    Stream stream = Stream::kDepth;
    bool depth = true;   // depth is rounded; the widths are those of the rounded depth
    bool scaled = true;  // the stream travels in units of its bands' scales
  };

  bool& is_raw(Stream stream) noexcept { return is_raw_[static_cast<std::size_t>(stream) - 1]; }
  template <typename T>
  std::span<T> room(std::size_t count) noexcept;
  template <typename T>
  void add_image(dsp::ImageView<const T> image, Stream stream, Coding coding,
                 PartStore& store) noexcept;
  template <typename T>
  void add_values(std::span<const T> values, const Raster& raster, Coding coding,
                  PartStore& store) noexcept;
  void add_depth_and_width(const dsp::DepthMap& map, const StreamChoice& choice,
                           PartStore& store) noexcept;
  std::span<std::uint16_t> rounded(const dsp::DepthMap& map, const Rounding& rounding) noexcept;
  void add_scaled_tiles(std::span<std::uint16_t> values, const Raster& raster,
                        PartStore& store) noexcept;
  void add_source(const dsp::DepthMap& map, Coding coding, PartStore& store) noexcept;
  bool add_xor_deltas(std::span<std::uint8_t> values, Raster raster, PartStore& store) noexcept;

  std::span<std::uint16_t> values16_;    // of an image that is not one piece in memory
  std::span<std::uint8_t> values8_;      // the same memory
  std::span<std::uint8_t> scales_;       // of the map's bands
  std::array<bool, kStreams> is_raw_{};  // RVL of this stream would have been longer
  bool no_xor_deltas_ = false;           // the source goes as it is
};

}  // namespace stof::wire

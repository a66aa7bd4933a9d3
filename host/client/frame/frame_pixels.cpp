#include "host/client/frame/frame_pixels.h"

#include <algorithm>
#include <limits>

#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl_decode.h"

namespace stof::client {
namespace {

using wire::Stream;

constexpr std::size_t kPmdSamples = 4;
constexpr std::uint8_t kSourceBits = 0x0F;
constexpr int kCauseShift = 4;
constexpr std::uint16_t kDisparityOffset = 0x8000;

template <typename T>
bool read(const wire::PacketView& tile, std::span<T> pixels) noexcept {
  const wire::Codec codec = tile.header.codec;
  if (codec == wire::Codec::kRvl16 || codec == wire::Codec::kRvl8) {
    return wire::rvl_decode<T>(tile.payload, pixels) == Status::kOk;
  }
  wire::get_pixels(tile.payload, pixels);
  return true;
}

// Depth and width. false: also where a pixel is more than 16 bits hold.
bool read_scaled(const wire::PacketView& tile, std::span<std::uint16_t> pixels) noexcept {
  if (!read(tile, pixels)) {
    return false;
  }
  const unsigned scale = wire::scale_of(tile.header);
  if (scale == 0) {
    return true;
  }
  const unsigned most = std::numeric_limits<std::uint16_t>::max() >> scale;
  if (std::ranges::any_of(pixels, [most](std::uint16_t pixel) { return pixel > most; })) {
    return false;
  }
  std::ranges::transform(pixels, pixels.begin(), [scale](std::uint16_t pixel) {
    return static_cast<std::uint16_t>(pixel << scale);
  });
  return true;
}

// Pixels [first, first + count) of an image that has room for `pixels`.
template <typename T>
std::span<T> room(std::vector<T>& image, std::size_t pixels, std::size_t first, std::size_t count) {
  if (image.size() < pixels) {
    image.resize(pixels);
  }
  return std::span(image).subspan(first, count);
}

}  // namespace

std::size_t FramePixels::mask_index_of(Stream stream) noexcept {
  const std::size_t index = index_of(stream);
  const std::size_t shared = index_of(Stream::kSource);
  return index <= shared ? 0 : index - shared;
}

bool FramePixels::present(Stream stream) const noexcept {
  const Layer& layer = layers_[index_of(stream)];
  return layer.received != 0 || (layer.sent && mask(stream).open());
}

void FramePixels::begin() noexcept {
  for (ArrivalMask& mask : masks_) {
    mask.begin();
  }
  layers_ = {};
}

bool FramePixels::expect(const wire::Header& header, const wire::FrameInfo& info) {
  const bool map_sent = info.tiles[index_of(Stream::kDepth)] != 0 ||
                        info.tiles[index_of(Stream::kWidth)] != 0 ||
                        info.tiles[index_of(Stream::kSource)] != 0;
  if (map_sent && !masks_[0].fits(header)) {
    return false;
  }
  for (std::size_t i = 0; i < kStreams; ++i) {
    layers_[i].sent = info.tiles[i] != 0;
  }
  return true;
}

Placed FramePixels::add(const wire::PacketView& tile) {
  const wire::Header& header = tile.header;
  if (wire::pixel_bytes(header.stream, header.codec) == 0) {
    return Placed::kIgnored;
  }
  ArrivalMask& mask = masks_[mask_index_of(header.stream)];
  const bool was_open = mask.open();
  if (!mask.fits(header)) {
    return Placed::kContradicting;
  }
  const std::size_t first =
      std::size_t{header.first_row} * header.image_width + header.first_column;
  const std::uint8_t bit = mark_of(header.stream);
  if (!mask.vacant(first, header.pixel_count, bit) || !decode(tile, first, mask.pixels())) {
    if (!was_open) {
      mask.begin();
    }
    return Placed::kContradicting;
  }
  mask.mark(first, header.pixel_count, bit);
  layers_[index_of(header.stream)].received += header.pixel_count;
  return Placed::kStored;
}

bool FramePixels::decode(const wire::PacketView& tile, std::size_t first, std::size_t pixels) {
  const std::size_t count = tile.header.pixel_count;
  switch (tile.header.stream) {
    case Stream::kDepth:
      return read_scaled(tile, room(depth_, pixels, first, count));
    case Stream::kWidth:
      return read_scaled(tile, room(width_, pixels, first, count));
    case Stream::kSource:
      return decode_source(tile, first, pixels);
    case Stream::kDisparity:
      return decode_disparity(tile, first, pixels);
    case Stream::kPmdRaw:
      return tile.header.image_height % kPmdSamples == 0 &&
             read(tile, room(pmd_, pixels, first, count));
    case Stream::kGreyLeft:
      return read(tile, room(left_, pixels, first, count));
    case Stream::kGreyRight:
      return read(tile, room(right_, pixels, first, count));
    case Stream::kCloud:
      wire::get_pixels(tile.payload, room(cloud_, pixels, first, count));
      return true;
    default:  // of no frame
      break;
  }
  return false;
}

bool FramePixels::decode_source(const wire::PacketView& tile, std::size_t first,
                                std::size_t pixels) {
  const std::size_t count = tile.header.pixel_count;
  const std::span<std::uint8_t> both = room(bytes_, count, 0, count);
  if (!read(tile, both)) {
    return false;
  }
  if (wire::is_xor_delta(tile.header)) {
    const std::size_t width = tile.header.image_width;
    for (std::size_t i = 1; i < count; ++i) {
      const bool begins_row = (first + i) % width == 0;
      both[i] = begins_row ? both[i] : static_cast<std::uint8_t>(both[i] ^ both[i - 1]);
    }
  }
  const std::span<dsp::Source> source = room(source_, pixels, first, count);
  const std::span<dsp::Cause> cause = room(cause_, pixels, first, count);
  for (std::size_t i = 0; i < count; ++i) {
    source[i] = static_cast<dsp::Source>(both[i] & kSourceBits);
    cause[i] = static_cast<dsp::Cause>(both[i] >> kCauseShift);
  }
  return true;
}

bool FramePixels::decode_disparity(const wire::PacketView& tile, std::size_t first,
                                   std::size_t pixels) {
  const std::size_t count = tile.header.pixel_count;
  const std::span<std::uint16_t> words = room(words_, count, 0, count);
  if (!read(tile, words)) {
    return false;
  }
  const std::span<dsp::Disparity> disparity = room(disparity_, pixels, first, count);
  for (std::size_t i = 0; i < count; ++i) {
    disparity[i] = dsp::Disparity::from_raw(static_cast<std::int16_t>(words[i] ^ kDisparityOffset));
  }
  return true;
}

template <typename T>
void FramePixels::finish(Stream stream, std::vector<T>& image, const T& none) {
  const ArrivalMask& mask = masks_[mask_index_of(stream)];
  if (!present(stream) || layers_[index_of(stream)].received == mask.pixels()) {
    return;
  }
  room(image, mask.pixels(), 0, 0);
  mask.blank(image, mark_of(stream), none);
}

void FramePixels::finish() {
  finish(Stream::kDepth, depth_, dsp::kNoDepth);
  finish(Stream::kWidth, width_, dsp::QuarterMm{0});
  finish(Stream::kSource, source_, dsp::Source::kNone);
  finish(Stream::kSource, cause_, dsp::Cause::kNone);
  finish(Stream::kDisparity, disparity_, dsp::Disparity::none());
  finish(Stream::kPmdRaw, pmd_, std::uint16_t{0});
  finish(Stream::kGreyLeft, left_, std::uint8_t{0});
  finish(Stream::kGreyRight, right_, std::uint8_t{0});
  finish(Stream::kCloud, cloud_, CloudPoint{});
}

template <typename T>
dsp::ImageView<const T> FramePixels::image(Stream stream,
                                           const std::vector<T>& pixels) const noexcept {
  if (!present(stream)) {
    return {};
  }
  return {pixels.data(), mask(stream).columns(), mask(stream).rows()};
}

void FramePixels::view(Frame& frame) const {
  frame.depth = image(Stream::kDepth, depth_);
  frame.interval_width = image(Stream::kWidth, width_);
  frame.source = image(Stream::kSource, source_);
  frame.cause = image(Stream::kSource, cause_);
  frame.received = masks_[0].marks();
  frame.disparity = image(Stream::kDisparity, disparity_);
  frame.left = image(Stream::kGreyLeft, left_);
  frame.right = image(Stream::kGreyRight, right_);
  frame.cloud = image(Stream::kCloud, cloud_);
  if (present(Stream::kPmdRaw)) {
    const int columns = mask(Stream::kPmdRaw).columns();
    const int rows = mask(Stream::kPmdRaw).rows() / static_cast<int>(kPmdSamples);
    const std::size_t sample = mask(Stream::kPmdRaw).pixels() / kPmdSamples;
    for (std::size_t i = 0; i < kPmdSamples; ++i) {
      frame.pmd[i] = {std::span(pmd_).subspan(i * sample).data(), columns, rows};
    }
  }
  for (std::size_t i = 0; i < kStreams; ++i) {
    const auto stream = static_cast<Stream>(i + 1);
    if (present(stream)) {
      frame.marks[i] = mask(stream).marks();
      frame.missing[i] = static_cast<std::uint32_t>(mask(stream).pixels()) - layers_[i].received;
    }
  }
}

}  // namespace stof::client

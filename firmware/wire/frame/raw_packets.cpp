#include "firmware/wire/frame/raw_packets.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/messages/stream_signature.h"

namespace stof::wire {
namespace {

static_assert(kMaxRawPayload + kStreamSignatureBytes == kMaxPayload);
static_assert(kMaxRawPayload >= kRawInfoBytes);

constexpr std::size_t kMostOfHeader = std::numeric_limits<std::uint16_t>::max();
constexpr std::size_t kPmdPixels = kMaxRawPayload / sizeof(std::uint16_t);  // of a tile

constexpr std::size_t tiles_of(std::size_t pixels, std::size_t most) noexcept {
  return (pixels + most - 1) / most;
}

// How many of `size` columns or rows are sent: each step-th from `first` on, of `wanted`, 0: all
// that follow.
std::uint16_t sent_of(int size, std::uint16_t first, std::uint16_t wanted, int step) noexcept {
  const int left = size - first;
  const int part = wanted == 0 ? left : std::min<int>(left, wanted);
  return static_cast<std::uint16_t>(part <= 0 ? 0 : (part + step - 1) / step);
}

}  // namespace

RawPackets::RawPackets(const Origin& origin, const FrameStamp& stamp, const RawImages& images,
                       const RawRequest& request, const RawInfo& info) noexcept
    : origin_(origin), stamp_(stamp), images_(images), info_(info) {
  const auto& either = images.left.empty() ? images.right : images.left;
  const auto& samples = images.samples.front();
  const std::uint8_t step = std::max<std::uint8_t>(request.step, 1);
  info_.step = step;
  info_.column = request.column;
  info_.row = request.row;
  info_.width = sent_of(either.width(), request.column, request.width, step);
  info_.height = sent_of(either.height(), request.row, request.height, step);
  if (info_.width == 0 || info_.height == 0) {
    info_.width = 0;
    info_.height = 0;
  }
  info_.camera_width = static_cast<std::uint16_t>(either.width());
  info_.camera_height = static_cast<std::uint16_t>(either.height());
  info_.pmd_width = static_cast<std::uint16_t>(samples.width());
  info_.pmd_height = static_cast<std::uint16_t>(samples.height());
  info_.pictures = 0;
  std::size_t count = 1;
  const auto add = [&](std::uint8_t picture, std::size_t tiles) {
    info_.pictures |= tiles > 0 ? picture : std::uint8_t{0};
    count += tiles;
  };
  add(kRawLeft, images.left.empty() ? 0 : tiles_of_eye());
  add(kRawRight, images.right.empty() ? 0 : tiles_of_eye());
  add(kRawPmd, tiles_of_pmd());
  const bool fits =
      static_cast<std::size_t>(std::max(either.width(), either.height())) <= kMostOfHeader &&
      kRawSamples * static_cast<std::size_t>(samples.height()) <= kMostOfHeader &&
      static_cast<std::size_t>(samples.width()) <= kMostOfHeader && count <= kMostOfHeader;
  count_ = fits ? count : 0;
}

std::size_t RawPackets::tiles_of_eye() const noexcept {
  return tiles_of(std::size_t{info_.width} * info_.height, kMaxRawPayload);
}

std::size_t RawPackets::tiles_of_pmd() const noexcept {
  return tiles_of(kRawSamples * info_.pmd_width * info_.pmd_height, kPmdPixels);
}

std::span<const std::byte> RawPackets::seal(std::size_t index,
                                            DatagramBuffer& buffer) const noexcept {
  STOF_CHECK(index < count_);
  if (index == 0) {
    return seal_info(buffer);
  }
  Tile tile{.index = index - 1, .packet = index};
  for (const auto& [picture, stream] :
       {std::pair{kRawLeft, Stream::kRawLeft}, std::pair{kRawRight, Stream::kRawRight}}) {
    const std::size_t tiles = (info_.pictures & picture) != 0 ? tiles_of_eye() : 0;
    if (tile.index < tiles) {
      return seal_pair(stream, tile, buffer);
    }
    tile.index -= tiles;
  }
  return seal_pmd(tile, buffer);
}

std::span<const std::byte> RawPackets::seal_info(DatagramBuffer& buffer) const noexcept {
  encode_raw_info(info_, payload_space(buffer).first<kRawInfoBytes>());
  return seal_packet(header(PacketType::kRawInfo, 0), kRawInfoBytes, buffer);
}

std::span<const std::byte> RawPackets::seal_pair(Stream stream, const Tile& place,
                                                 DatagramBuffer& buffer) const noexcept {
  const auto& picture = stream == Stream::kRawLeft ? images_.left : images_.right;
  const std::size_t width = info_.width;
  const std::size_t first = place.index * kMaxRawPayload;
  const std::size_t pixels = std::min(kMaxRawPayload, width * info_.height - first);
  const std::span<std::byte> out = payload_space(buffer);
  for (std::size_t done = 0; done < pixels;) {
    const std::size_t column = (first + done) % width;
    const std::size_t run = std::min(width - column, pixels - done);
    const auto row =
        picture.row(static_cast<int>(info_.row + (first + done) / width * std::size_t{info_.step}));
    const std::size_t from = info_.column + column * info_.step;
    for (std::size_t i = 0; i < run; ++i) {
      out[done + i] = static_cast<std::byte>(row[from + i * info_.step]);
    }
    done += run;
  }
  Header tile = header(PacketType::kRawTile, place.packet);
  tile.stream = stream;
  tile.codec = Codec::kRaw8;
  tile.image_width = info_.width;
  tile.image_height = info_.height;
  tile.first_row = static_cast<std::uint16_t>(first / width);
  tile.first_column = static_cast<std::uint16_t>(first % width);
  tile.pixel_count = static_cast<std::uint16_t>(pixels);
  return seal_packet(tile, pixels, buffer);
}

std::span<const std::byte> RawPackets::seal_pmd(const Tile& place,
                                                DatagramBuffer& buffer) const noexcept {
  const std::size_t width = info_.pmd_width;
  const std::size_t height = info_.pmd_height;
  const std::size_t first = place.index * kPmdPixels;
  const std::size_t pixels = std::min(kPmdPixels, kRawSamples * width * height - first);
  const std::span<std::byte> out = payload_space(buffer);
  for (std::size_t done = 0; done < pixels;) {
    const std::size_t column = (first + done) % width;
    const std::size_t row = (first + done) / width;
    const std::size_t run = std::min(width - column, pixels - done);
    put_pixels<std::uint16_t>(
        out.subspan(done * sizeof(std::uint16_t), run * sizeof(std::uint16_t)),
        images_.samples[row / height].row(static_cast<int>(row % height)).subspan(column, run));
    done += run;
  }
  Header tile = header(PacketType::kRawTile, place.packet);
  tile.stream = Stream::kRawPmd;
  tile.codec = Codec::kRaw16;
  tile.image_width = info_.pmd_width;
  tile.image_height = static_cast<std::uint16_t>(kRawSamples * height);
  tile.first_row = static_cast<std::uint16_t>(first / width);
  tile.first_column = static_cast<std::uint16_t>(first % width);
  tile.pixel_count = static_cast<std::uint16_t>(pixels);
  return seal_packet(tile, pixels * sizeof(std::uint16_t), buffer);
}

Header RawPackets::header(PacketType type, std::size_t index) const noexcept {
  return {.type = type,
          .origin = origin_,
          .frame = stamp_,
          .index = static_cast<std::uint16_t>(index),
          .count = static_cast<std::uint16_t>(count_)};
}

bool consistent_raw_tile(const PacketView& packet) noexcept {
  const Header& header = packet.header;
  const bool pair = header.stream == Stream::kRawLeft || header.stream == Stream::kRawRight;
  const bool known = pair ? header.codec == Codec::kRaw8
                          : header.stream == Stream::kRawPmd && header.codec == Codec::kRaw16;
  const std::size_t width = header.image_width;
  const std::size_t first = header.first_row * width + header.first_column;
  return known && header.pixel_count > 0 && header.first_column < width &&
         first + header.pixel_count <= width * header.image_height &&
         packet.payload.size() == header.pixel_count * raw_pixel_bytes(header.codec);
}

}  // namespace stof::wire

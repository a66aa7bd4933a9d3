#include "firmware/wire/frame/frame_coder.h"

#include <algorithm>
#include <limits>

#include "dsp/base/check.h"
#include "dsp/fusion/decimate.h"
#include "firmware/wire/frame/cloud.h"
#include "firmware/wire/frame/streaming_encoder.h"
#include "firmware/wire/frame/tiles.h"

namespace stof::wire {
namespace {

constexpr std::size_t kMaxU16 = std::numeric_limits<std::uint16_t>::max();
static_assert(kFrameInfoBytes <= kMaxTilePayload);

constexpr std::size_t tiles_of(int width, int height, std::size_t pixel_bytes) noexcept {
  return raw_tiles(static_cast<std::size_t>(width), static_cast<std::size_t>(height), pixel_bytes);
}

// Parts of a frame of these sizes with every stream, raw.
constexpr std::size_t parts_of(const FrameSizes& sizes) noexcept {
  const int cloud_width = dsp::decimated(sizes.width, kLeastCloudStep);
  const int cloud_height = dsp::decimated(sizes.height, kLeastCloudStep);
  return 1 + 3 * tiles_of(sizes.width, sizes.height, 2) +
         3 * tiles_of(sizes.width, sizes.height, 1) +
         tiles_of(sizes.pmd_width, static_cast<int>(kPmdSamples) * sizes.pmd_height, 2) +
         tiles_of(cloud_width, cloud_height, kPointBytes);
}

// RVL is tried in the space of one part more.
constexpr std::size_t kSpare = 1;
constexpr std::size_t kLeastPackets = 8;
constexpr std::uint16_t kMostTold = 255;  // parity groups, of the frame info's byte

std::size_t buffers_of(const FrameSizes& sizes, std::size_t packets) noexcept {
  const std::size_t most = FrameCoder::most_packets(sizes);
  return std::min(std::max(packets, kLeastPackets), most) + kSpare;
}

std::size_t groups_of(const FrameSizes& sizes, std::size_t packets) noexcept {
  const std::size_t most = FrameCoder::most_packets(sizes);
  return packets < most ? most - parts_of(sizes) : 1;
}

template <typename T>
bool within(const dsp::ImageView<T>& image, int width, int height) noexcept {
  return image.empty() || (image.width() <= width && image.height() <= height);
}

}  // namespace

std::size_t FrameCoder::most_packets(const FrameSizes& sizes) noexcept {
  const std::size_t parts = parts_of(sizes);
  return parts + (parts + kParityGroupSize - 1) / kParityGroupSize;
}

std::size_t FrameCoder::usual_packets(const FrameSizes& sizes) noexcept {
  const std::size_t depth = tiles_of(sizes.width, sizes.height, sizeof(dsp::QuarterMm));
  return std::min(depth + depth / 5, most_packets(sizes));
}

FrameCoder::FrameCoder(const Origin& origin, const FrameSizes& sizes,
                       const CalibrationPacket& calibration, dsp::Arena& arena,
                       std::size_t packets) noexcept
    : origin_(origin), sizes_(sizes), calibration_(calibration), images_(sizes, arena) {
  const std::span<DatagramBuffer> buffers = arena.take<DatagramBuffer>(buffers_of(sizes, packets));
  store_ = PartStore(buffers, arena.take<Part>(parts_of(sizes) + kSpare));
  memory_ = {.datagrams = arena.take<std::span<const std::byte>>(buffers.size()),
             .groups = arena.take<ParityGroup>(groups_of(sizes, packets))};
}

bool FrameCoder::fits(const FrameImages& images) const noexcept {
  const auto holds = [this](const auto& image) {
    return within(image, sizes_.width, sizes_.height);
  };
  const auto holds_pmd = [this](const auto& image) {
    return within(image, sizes_.pmd_width, sizes_.pmd_height);
  };
  return parts_of(sizes_) <= kMaxU16 &&
         static_cast<std::size_t>(std::max(sizes_.width, sizes_.height)) <= kMaxU16 &&
         static_cast<std::size_t>(sizes_.pmd_width) <= kMaxU16 &&
         kPmdSamples * static_cast<std::size_t>(sizes_.pmd_height) <= kMaxU16 &&
         holds(images.map.depth) && holds(images.map.width) && holds(images.map.source) &&
         holds(images.disparity) && holds(images.left) && holds(images.right) &&
         std::ranges::all_of(images.pmd, holds_pmd);
}

void FrameCoder::add_streams(const FrameImages& images, const StreamChoice& choice) noexcept {
  const dsp::DepthMap& map = images.map;
  images_.add_map(map, choice, store_);
  images_.add_disparity(images.disparity, choice.of(Stream::kDisparity), store_);
  images_.add_pmd(images, choice.of(Stream::kPmdRaw), store_);
  images_.add_grey(images.left, Stream::kGreyLeft, choice.of(Stream::kGreyLeft), store_);
  images_.add_grey(images.right, Stream::kGreyRight, choice.of(Stream::kGreyRight), store_);
  if (choice.of(Stream::kCloud) != Coding::kOff && !map.depth.empty()) {
    add_cloud_tiles(map, choice.cloud_step, calibration_, store_);
  }
}

FrameInfo FrameCoder::counted(const FrameInfo& info, const StreamChoice& choice) noexcept {
  FrameInfo counted = info;
  counted.tiles = {};
  for (std::size_t i = 1; i < store_.size(); ++i) {
    ++counted.tiles[static_cast<std::size_t>(store_.part(i).stream) - 1];
  }
  const std::uint16_t groups = parity_groups(static_cast<std::uint16_t>(store_.size()));
  const bool cloud = counted.tiles[static_cast<std::size_t>(Stream::kCloud) - 1] > 0;
  counted.parity_groups =
      choice.parity ? static_cast<std::uint8_t>(std::min(groups, kMostTold)) : std::uint8_t{0};
  counted.cloud_step = cloud ? static_cast<std::uint8_t>(choice.cloud_step) : std::uint8_t{0};
  return counted;
}

void FrameCoder::add_info(const FrameImages& images) noexcept {
  const dsp::DepthMap& map = images.map;
  const int width = map.depth.empty() ? sizes_.width : map.depth.width();
  const int height = map.depth.empty() ? sizes_.height : map.depth.height();
  encode_frame_info(info_, store_.payload(0).first<kFrameInfoBytes>());
  store_.add({.type = PacketType::kFrameInfo,
              .image_width = static_cast<std::uint16_t>(width),
              .image_height = static_cast<std::uint16_t>(height),
              .payload_bytes = kFrameInfoBytes});
}

bool FrameCoder::count(const FrameInfo& info, const FrameImages& images,
                       const StreamChoice& choice) noexcept {
  images_.begin_frame();
  store_.clear();
  add_info(images);
  add_streams(images, choice);
  info_ = counted(info, choice);
  const auto parts = static_cast<std::uint16_t>(store_.size());
  return store_.whole() &&
         parts + (choice.parity ? parity_groups(parts) : std::size_t{0}) <= store_.buffers();
}

FrameSealer FrameCoder::sealer(const FrameStamp& stamp, const StreamChoice& choice) noexcept {
  return {origin_, stamp, store_, choice.parity, memory_};
}

Datagrams FrameCoder::seal_all(const FrameStamp& stamp, const StreamChoice& choice) noexcept {
  encode_frame_info(info_, store_.payload(0).first<kFrameInfoBytes>());
  return sealer(stamp, choice).seal_all();
}

Result<Datagrams> FrameCoder::code(const FrameStamp& stamp, const FrameInfo& info,
                                   const FrameImages& images, const StreamChoice& choice) noexcept {
  if (!fits(images) || !count(info, images, choice)) {
    return fail(Status::kTooLarge);
  }
  return seal_all(stamp, choice);
}

Status FrameCoder::code(const FrameStamp& stamp, const FrameInfo& info, const FrameImages& images,
                        const StreamChoice& choice, DatagramSink& sink) noexcept {
  if (!fits(images)) {
    return Status::kTooLarge;
  }
  if (count(info, images, choice)) {
    const Datagrams datagrams = seal_all(stamp, choice);
    sink.take(datagrams, datagrams.size());
    return Status::kOk;
  }
  StreamingEncoder encoder(sealer(stamp, choice), sink);
  const std::size_t counted = store_.size();
  store_.clear(&encoder);
  add_info(images);
  add_streams(images, choice);
  STOF_CHECK(store_.size() == counted);
  store_.finish();
  store_.clear();
  encoder.send_parity();
  return Status::kOk;
}

}  // namespace stof::wire

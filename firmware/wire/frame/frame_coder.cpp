#include "firmware/wire/frame/frame_coder.h"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/interval_quantiser.h"
#include "firmware/wire/frame/cloud.h"

namespace stof::wire {
namespace {

constexpr std::size_t kMaxU16 = std::numeric_limits<std::uint16_t>::max();
constexpr std::size_t kSamples = 4;  // of a PMD pixel
constexpr int kDisparityOffset = 32'768;
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
         tiles_of(sizes.pmd_width, static_cast<int>(kSamples) * sizes.pmd_height, 2) +
         tiles_of(cloud_width, cloud_height, kPointBytes);
}

constexpr std::size_t pixels16(const FrameSizes& sizes) noexcept {
  return std::max(static_cast<std::size_t>(sizes.width) * static_cast<std::size_t>(sizes.height),
                  kSamples * static_cast<std::size_t>(sizes.pmd_width) *
                      static_cast<std::size_t>(sizes.pmd_height));
}
// RVL is tried in the space of one part more.
constexpr std::size_t kSpare = 1;
constexpr std::size_t kLeastPackets = 8;
constexpr std::uint16_t kMostTold = 255;  // parity groups, of the frame info's byte

template <typename T>
bool within(const dsp::ImageView<T>& image, int width, int height) noexcept {
  return image.empty() || (image.width() <= width && image.height() <= height);
}

template <typename T>
void copy_image(dsp::ImageView<const T> image, std::span<T> out) noexcept {
  for (int y = 0; y < image.height(); ++y) {
    std::ranges::copy(image.row(y), out.begin());
    out = out.subspan(image.row(y).size());
  }
}

}  // namespace

std::size_t FrameCoder::most_packets(const FrameSizes& sizes) noexcept {
  const std::size_t parts = parts_of(sizes);
  return parts + (parts + kParityGroupSize - 1) / kParityGroupSize;
}

std::size_t FrameCoder::usual_packets(const FrameSizes& sizes) noexcept {
  const std::size_t depth = tiles_of(sizes.width, sizes.height, sizeof(dsp::QuarterMm));
  return std::min(depth + depth / 4, most_packets(sizes));
}

std::size_t FrameCoder::buffers_of(const FrameSizes& sizes, std::size_t packets) noexcept {
  return std::min(std::max(packets, kLeastPackets), most_packets(sizes)) + kSpare;
}

std::size_t FrameCoder::groups_of(const FrameSizes& sizes, std::size_t packets) noexcept {
  const std::size_t all = most_packets(sizes);
  return packets < all ? all - parts_of(sizes) : 1;
}

std::size_t FrameCoder::bytes_needed(const FrameSizes& sizes, std::size_t packets) noexcept {
  const std::size_t buffers = buffers_of(sizes, packets);
  return dsp::Arena::bytes_for<DatagramBuffer>(buffers) +
         dsp::Arena::bytes_for<Part>(parts_of(sizes) + kSpare) +
         dsp::Arena::bytes_for<std::span<const std::byte>>(buffers) +
         dsp::Arena::bytes_for<std::uint16_t>(pixels16(sizes)) +
         dsp::Arena::bytes_for<std::uint8_t>(fit_bands(sizes.height)) +
         dsp::Arena::bytes_for<ParityGroup>(groups_of(sizes, packets));
}

FrameCoder::FrameCoder(const Origin& origin, const FrameSizes& sizes,
                       const CalibrationPacket& calibration, dsp::Arena& arena,
                       std::size_t packets) noexcept
    : origin_(origin), sizes_(sizes), calibration_(calibration) {
  const std::span<DatagramBuffer> buffers = arena.take<DatagramBuffer>(buffers_of(sizes, packets));
  store_ = PartStore(buffers, arena.take<Part>(parts_of(sizes) + kSpare));
  datagrams_ = arena.take<std::span<const std::byte>>(buffers.size());
  values16_ = arena.take<std::uint16_t>(pixels16(sizes));
  values8_ = {reinterpret_cast<std::uint8_t*>(values16_.data()),  // NOLINT: one at a time
              values16_.size_bytes()};
  scales_ = arena.take<std::uint8_t>(fit_bands(sizes.height));
  groups_ = arena.take<ParityGroup>(groups_of(sizes, packets));
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
         kSamples * static_cast<std::size_t>(sizes_.pmd_height) <= kMaxU16 &&
         holds(images.map.depth) && holds(images.map.width) && holds(images.map.source) &&
         holds(images.disparity) && holds(images.left) && holds(images.right) &&
         std::ranges::all_of(images.pmd, holds_pmd);
}

template <typename T>
void FrameCoder::add_tiles(std::span<const T> values, Stream stream, int width, int height,
                           Coding coding) noexcept {
  add_values(values,
             {.stream = stream,
              .width = static_cast<std::size_t>(width),
              .height = static_cast<std::size_t>(height)},
             coding);
}

template <typename T>
void FrameCoder::add_values(std::span<const T> values, const Raster& raster,
                            Coding coding) noexcept {
  bool& is_raw = is_raw_[static_cast<std::size_t>(raster.stream) - 1];
  if (coding == Coding::kRaw || is_raw) {
    add_raw_tiles(values, raster, store_);
  } else {
    is_raw = !add_rvl_tiles(values, raster, store_);
  }
}

template <typename T>
std::span<T> FrameCoder::room(std::size_t count) noexcept {
  if constexpr (std::is_same_v<T, std::uint8_t>) {
    return values8_.first(count);
  } else {
    return values16_.first(count);
  }
}

template <typename T>
void FrameCoder::add_image(dsp::ImageView<const T> image, Stream stream, Coding coding) noexcept {
  if (coding == Coding::kOff || image.empty()) {
    return;
  }
  const std::size_t count =
      static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.height());
  if (image.stride() == image.width()) {
    add_tiles(std::span<const T>(image.data(), count), stream, image.width(), image.height(),
              coding);
    return;
  }
  const std::span<T> values = room<T>(count);
  copy_image(image, values);
  add_tiles<T>(values, stream, image.width(), image.height(), coding);
}

// Those that add_map() uses.
template void FrameCoder::add_image(dsp::ImageView<const dsp::QuarterMm>, Stream, Coding) noexcept;
template void FrameCoder::add_values(std::span<const std::uint8_t>, const Raster&, Coding) noexcept;
template void FrameCoder::add_tiles(std::span<const std::uint8_t>, Stream, int, int,
                                    Coding) noexcept;
template void FrameCoder::add_tiles(std::span<const std::uint16_t>, Stream, int, int,
                                    Coding) noexcept;

void FrameCoder::add_disparity(dsp::ImageView<const dsp::Disparity> image, Coding coding) noexcept {
  if (coding == Coding::kOff || image.empty()) {
    return;
  }
  const auto columns = static_cast<std::size_t>(image.width());
  const std::span<std::uint16_t> values =
      values16_.first(columns * static_cast<std::size_t>(image.height()));
  for (int y = 0; y < image.height(); ++y) {
    const std::span<std::uint16_t> out =
        values.subspan(static_cast<std::size_t>(y) * columns, columns);
    std::ranges::transform(image.row(y), out.begin(), [](dsp::Disparity disparity) {
      return static_cast<std::uint16_t>(disparity.raw + kDisparityOffset);  // none becomes 0
    });
  }
  add_tiles<std::uint16_t>(values, Stream::kDisparity, image.width(), image.height(), coding);
}

void FrameCoder::add_pmd(const FrameImages& images, Coding coding) noexcept {
  const dsp::ImageView<const std::uint16_t>& first = images.pmd.front();
  if (coding == Coding::kOff || first.empty()) {
    return;
  }
  const std::size_t count =
      static_cast<std::size_t>(first.width()) * static_cast<std::size_t>(first.height());
  const std::span<std::uint16_t> values = values16_.first(kSamples * count);
  for (std::size_t k = 0; k < kSamples; ++k) {
    STOF_CHECK(same_size(images.pmd[k], first));
    copy_image(images.pmd[k], values.subspan(k * count, count));
  }
  add_tiles<std::uint16_t>(values, Stream::kPmdRaw, first.width(),
                           static_cast<int>(kSamples) * first.height(), coding);
}

void FrameCoder::add_streams(const FrameImages& images, const StreamChoice& choice) noexcept {
  const dsp::DepthMap& map = images.map;
  add_map(map, choice);
  add_disparity(images.disparity, choice.of(Stream::kDisparity));
  add_pmd(images, choice.of(Stream::kPmdRaw));
  add_image(images.left, Stream::kGreyLeft, choice.of(Stream::kGreyLeft));
  add_image(images.right, Stream::kGreyRight, choice.of(Stream::kGreyRight));
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
  is_raw_ = {};
  no_steps_ = false;
  store_.clear();
  add_info(images);
  add_streams(images, choice);
  info_ = counted(info, choice);
  const auto parts = static_cast<std::uint16_t>(store_.size());
  return store_.whole() &&
         parts + (choice.parity ? parity_groups(parts) : std::size_t{0}) <= store_.buffers();
}

}  // namespace stof::wire

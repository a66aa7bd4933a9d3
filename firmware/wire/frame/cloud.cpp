#include "firmware/wire/frame/cloud.h"

#include <algorithm>
#include <limits>

#include "firmware/wire/bytes.h"

namespace stof::wire {
namespace {

constexpr std::int64_t kOnePixel = 65'536;
constexpr std::int64_t kDepthsPerMm = 4;

void put_point(const dsp::NearestPixel& pixel, const CalibrationPacket& lens,
               std::span<std::byte, kPointBytes> out) noexcept {
  if (pixel.depth == dsp::kNoDepth) {
    put_u64(out, 0);
    return;
  }
  put_u16(out.subspan<0, 2>(),
          static_cast<std::uint16_t>(point_mm(pixel.x, pixel.depth, lens.fx, lens.cx)));
  put_u16(out.subspan<2, 2>(),
          static_cast<std::uint16_t>(point_mm(pixel.y, pixel.depth, lens.fy, lens.cy)));
  put_u16(out.subspan<4, 2>(), pixel.depth);
  put_u16(out.subspan<6, 2>(), pixel.width);
}

}  // namespace

std::int16_t point_mm(int pixel, dsp::QuarterMm depth, std::int32_t focal,
                      std::int32_t centre) noexcept {
  const std::int64_t dividend = (pixel * kOnePixel - centre) * depth;
  const std::int64_t divisor = kDepthsPerMm * focal;
  const std::int64_t raised = dividend + divisor / 2;
  // Towards minus infinity, where division goes towards 0.
  const std::int64_t mm = raised / divisor - (raised % divisor < 0 ? 1 : 0);
  using Limits = std::numeric_limits<std::int16_t>;
  return static_cast<std::int16_t>(std::clamp<std::int64_t>(mm, Limits::min(), Limits::max()));
}

void add_cloud_tiles(const dsp::DepthMap& map, int step, const CalibrationPacket& lens,
                     PartStore& store) noexcept {
  STOF_CHECK(step >= kLeastCloudStep && lens.fx > 0 && lens.fy > 0);
  const int columns = dsp::decimated(map.depth.width(), step);
  const Raster raster{.stream = Stream::kCloud,
                      .width = static_cast<std::size_t>(columns),
                      .height = static_cast<std::size_t>(dsp::decimated(map.depth.height(), step))};
  for (std::size_t first = 0; first < raster.width * raster.height;) {
    const std::size_t points = raw_pixels(raster, first, kPointBytes);
    std::span<std::byte> out = store.space();
    for (std::size_t i = first; i < first + points; ++i) {
      const int block = static_cast<int>(i);
      put_point(dsp::nearest_pixel(map, step, block % columns, block / columns), lens,
                out.first<kPointBytes>());
      out = out.subspan(kPointBytes);
    }
    store.add(raster.part(Codec::kPoints, first, points, points * kPointBytes));
    first += points;
  }
}

}  // namespace stof::wire

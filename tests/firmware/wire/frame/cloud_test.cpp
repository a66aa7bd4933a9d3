#include "firmware/wire/frame/cloud.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::wire {
namespace {

using test::Random;
using test::RandomMap;

constexpr std::int32_t kOnePixel = 65'536;
constexpr CalibrationPacket kLens{.fx = 500 * kOnePixel + 7,
                                  .fy = 490 * kOnePixel,
                                  .cx = 50 * kOnePixel - 30'000,
                                  .cy = 20 * kOnePixel};

TEST(CloudTest, RoundsMillimetresToTheNearest) {
  constexpr std::int32_t kFocal = 100 * kOnePixel;
  EXPECT_EQ(point_mm(100, 4000, kFocal, 0), 1000);  // 45 degrees at 1 m
  EXPECT_EQ(point_mm(0, 4000, kFocal, 0), 0);
  EXPECT_EQ(point_mm(1, 200, kFocal, 0), 1);  // 0.5 mm: up
  EXPECT_EQ(point_mm(1, 199, kFocal, 0), 0);
  EXPECT_EQ(point_mm(0, 200, kFocal, kOnePixel), 0);  // -0.5 mm: up
  EXPECT_EQ(point_mm(0, 201, kFocal, kOnePixel), -1);
  EXPECT_EQ(point_mm(65'535, 65'535, 1, 0), 32'767);  // limited
  EXPECT_EQ(point_mm(0, 65'535, 1, 2'000'000'000), -32'768);
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const int u = random.between(0, 1279);
    const auto z = static_cast<dsp::QuarterMm>(random.between(1, 40'000));
    const double x = (u - kLens.cx / 65536.0) * z / 4 / (kLens.fx / 65536.0);
    EXPECT_EQ(point_mm(u, z, kLens.fx, kLens.cx), std::lround(x)) << u << " " << z;
  }
}

TEST(CloudTest, SendsTheNearestPixelOfEachBlock) {
  for (const int step : {2, 5, 8, 64}) {
    RandomMap random_map(331, 45, static_cast<std::uint64_t>(step));
    const dsp::DepthMap map = random_map.view();
    for (int y = 0; y < 45; ++y) {
      for (int x = 0; x < 100; ++x) {
        map.depth.at(x, y) = 0;  // whole blocks without a depth
      }
    }
    std::vector<DatagramBuffer> buffers(200);
    std::vector<Part> parts(200);
    PartStore store(buffers, parts);
    add_cloud_tiles(map, step, kLens, store);

    const int columns = dsp::decimated(331, step);
    const int rows = dsp::decimated(45, step);
    int block = 0;
    for (std::size_t i = 0; i < store.size(); ++i) {
      const Part& part = store.part(i);
      ASSERT_EQ(part.stream, Stream::kCloud);
      ASSERT_EQ(part.codec, Codec::kPoints);
      ASSERT_EQ(part.image_width, columns);
      ASSERT_EQ(part.image_height, rows);
      ASSERT_EQ(part.first_row * columns + part.first_column, block);
      ASSERT_EQ(part.payload_bytes, part.pixel_count * kPointBytes);
      std::span<const std::byte> bytes = store.payload(i);
      for (int k = 0; k < part.pixel_count; ++k, ++block, bytes = bytes.subspan(kPointBytes)) {
        const dsp::NearestPixel want =
            dsp::nearest_pixel(map, step, block % columns, block / columns);
        ASSERT_EQ(get_u16(bytes.subspan(4).first<2>()), want.depth);
        if (want.depth == dsp::kNoDepth) {
          ASSERT_EQ(get_u64(bytes.first<8>()), 0U);
          continue;
        }
        const auto x = static_cast<std::int16_t>(get_u16(bytes.first<2>()));
        const auto y = static_cast<std::int16_t>(get_u16(bytes.subspan(2).first<2>()));
        ASSERT_EQ(x, point_mm(want.x, want.depth, kLens.fx, kLens.cx));
        ASSERT_EQ(y, point_mm(want.y, want.depth, kLens.fy, kLens.cy));
        ASSERT_EQ(get_u16(bytes.subspan(6).first<2>()), want.width);
      }
    }
    ASSERT_EQ(block, columns * rows);
  }
}

}  // namespace
}  // namespace stof::wire

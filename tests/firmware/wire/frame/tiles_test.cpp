#include "firmware/wire/frame/tiles.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "firmware/wire/codec/rvl_encode.h"
#include "tests/support/random.h"

namespace stof::wire {
namespace {

using test::Random;

// Parts of an image, with memory.
struct Cut {
  explicit Cut(std::size_t most) : buffers(most + 1), parts(most + 1), store(buffers, parts) {}

  std::vector<DatagramBuffer> buffers;
  std::vector<Part> parts;
  PartStore store;
};

template <typename T>
Cut cut(const std::vector<T>& values, const Raster& raster, bool rvl) {
  Cut cut(raw_tiles(raster.width, raster.height, sizeof(T)));
  if (rvl) {
    add_rvl_tiles<T>(values, raster, cut.store);
  } else {
    add_raw_tiles<T>(values, raster, cut.store);
  }
  return cut;
}

// Places every tile by its own part alone; each pixel comes once.
template <typename T>
void expect_image(Cut& cut, const std::vector<T>& values, const Raster& raster) {
  std::vector<T> image(values.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < cut.store.size(); ++i) {
    const Part& part = cut.store.part(i);
    ASSERT_EQ(part.stream, raster.stream);
    ASSERT_EQ(part.image_width, raster.width);
    ASSERT_EQ(part.image_height, raster.height);
    ASSERT_EQ(part.first_row * raster.width + part.first_column, next);
    ASSERT_GT(part.pixel_count, 0);
    ASSERT_LE(part.payload_bytes, kMaxTilePayload);
    const std::span<const std::byte> payload =
        std::span<const std::byte>(cut.store.payload(i)).first(part.payload_bytes);
    const std::span<T> pixels = std::span(image).subspan(next, part.pixel_count);
    if (raw_pixel_bytes(part.codec) > 0) {
      ASSERT_EQ(payload.size(), pixels.size_bytes());
      get_pixels(payload, pixels);
    } else {
      ASSERT_EQ(rvl_decode<T>(payload, pixels), Status::kOk);
      ASSERT_LE(payload.size(), pixels.size_bytes());  // otherwise it goes raw
    }
    next += part.pixel_count;
  }
  ASSERT_EQ(next, values.size());
  ASSERT_EQ(image, values);
}

// Whether a row fits a packet alone.
template <typename T>
bool row_fits(const std::vector<T>& values, const Raster& raster, std::size_t y, bool rvl) {
  std::vector<std::byte> space(kMaxTilePayload);
  const auto row = std::span<const T>(values).subspan(y * raster.width, raster.width);
  return row.size_bytes() <= kMaxTilePayload ||
         (rvl && rvl_encode<T>(row, space).values == raster.width);
}

template <typename T>
void expect_whole_rows(Cut& cut, const std::vector<T>& values, const Raster& raster, bool rvl) {
  for (std::size_t i = 0; i < cut.store.size(); ++i) {
    const Part& part = cut.store.part(i);
    if (part.first_column > 0) {
      ASSERT_FALSE(row_fits(values, raster, part.first_row, rvl)) << "row " << part.first_row;
    }
  }
}

template <typename T>
std::vector<T> picture(const Raster& raster, int kind, std::uint64_t seed) {
  Random random(seed);
  std::vector<T> values(raster.width * raster.height);
  int level = 100;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t y = i / raster.width;
    // Kinds: 0 empty, 1 noise, 2 smooth with holes, 3 rows of noise among smooth ones.
    const bool noise = kind == 1 || (kind == 3 && y % 5 < 2);
    level = std::clamp(level + random.between(-3, 3), 1, 255);
    if (noise) {
      values[i] = static_cast<T>(random.next());
    } else if (kind != 0 && i / 40 % 7 != 0) {
      values[i] = static_cast<T>(level);
    }
  }
  return values;
}

template <typename T>
void expect_all_cuts() {
  for (const std::size_t width :
       {1U, 3U, 64U, 563U, 565U, 566U, 640U, 1130U, 1131U, 1280U, 5000U}) {
    for (const std::size_t height : {1U, 2U, 37U}) {
      for (int kind = 0; kind < 4; ++kind) {
        const Raster raster{.stream = Stream::kWidth, .width = width, .height = height};
        SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height) + " kind " +
                     std::to_string(kind));
        const std::vector<T> values = picture<T>(raster, kind, width + height);
        for (const bool rvl : {false, true}) {
          Cut tiles = cut(values, raster, rvl);
          expect_image(tiles, values, raster);
          expect_whole_rows(tiles, values, raster, rvl);
          ASSERT_LE(tiles.store.size(), raw_tiles(width, height, sizeof(T)));
          if (!rvl) {
            ASSERT_EQ(tiles.store.size(), raw_tiles(width, height, sizeof(T)));
          }
        }
      }
    }
  }
}

TEST(TilesTest, PlacesEveryPixelOnceAndSplitsNoRowThatFits16) { expect_all_cuts<std::uint16_t>(); }
TEST(TilesTest, PlacesEveryPixelOnceAndSplitsNoRowThatFits8) { expect_all_cuts<std::uint8_t>(); }

// A row whose code grows nibble by nibble over what a payload takes, and whose last run goes on in
// the next row, with a length of more nibbles.
std::vector<std::uint16_t> row_at_the_limit(std::size_t steep, std::size_t wide) {
  std::vector<std::uint16_t> row(700, 40'000);
  for (std::size_t x = 0; x < steep; ++x) {
    row[x] = x % 2 == 0 ? 30'000 : 1;  // six nibbles each
  }
  row[700 - 64] = 0;
  for (std::size_t x = 0; x < wide; ++x) {
    row[steep + 1 + x] = static_cast<std::uint16_t>(40'000 + 20 * (x + 1));
  }
  return row;
}

TEST(TilesTest, SplitsNoRowThatFitsByOneNibble) {
  const Raster raster{.stream = Stream::kDepth, .width = 700, .height = 3};
  Random random(1);
  std::vector<std::uint16_t> noise(700);
  random.fill(std::span(noise), 1, 65'535);
  const std::vector<std::uint16_t> zeros(700);
  std::size_t split = 0;
  for (std::size_t steep = 300; steep < 340; ++steep) {
    for (std::size_t wide = 0; wide < 7; ++wide) {
      const std::vector<std::uint16_t> row = row_at_the_limit(steep, wide);
      for (const auto& rows : {std::array{row, row, row}, std::array{row, noise, row},
                               std::array{zeros, row, noise}}) {
        std::vector<std::uint16_t> values;
        for (const std::vector<std::uint16_t>& each : rows) {
          values.insert(values.end(), each.begin(), each.end());
        }
        Cut tiles = cut(values, raster, true);
        expect_image(tiles, values, raster);
        expect_whole_rows(tiles, values, raster, true);
        split += row_fits(values, raster, 1, true) ? 0U : 1U;
      }
    }
  }
  EXPECT_TRUE(split > 350 && split < 800) << split;  // of 840: both sides of the limit
}

TEST(TilesTest, NoiseCostsRawPacketsAndTheRestAlmostNone) {
  const Raster raster{.stream = Stream::kDepth, .width = 640, .height = 40};
  std::vector<std::uint16_t> values = picture<std::uint16_t>(raster, 1, 3);
  std::fill(values.begin() + 20 * 640, values.end(), std::uint16_t{0});
  Cut tiles = cut(values, raster, true);
  expect_image(tiles, values, raster);
  EXPECT_LE(tiles.store.size(), raw_tiles(640, 20, 2) + 1);
}

TEST(TilesTest, RawTilesAreCountedBeforehand) {
  EXPECT_EQ(raw_tiles(640, 480, 2), 544U);  // 565 pixels each
  EXPECT_EQ(raw_tiles(640, 480, 1), 480U);
  EXPECT_EQ(raw_tiles(160, 120, 2), 40U);  // three rows each
  EXPECT_EQ(raw_tiles(0, 480, 2), 0U);
}

TEST(TilesTest, AnEmptyImageTakesFewPackets) {
  const Raster raster{.stream = Stream::kDepth, .width = 640, .height = 480};
  Cut tiles = cut(std::vector<std::uint16_t>(640 * 480), raster, true);
  EXPECT_EQ(tiles.store.size(), 5U);  // 102 rows of at most 65,535 pixels each
  EXPECT_EQ(tiles.store.part(0).pixel_count, 102 * 640);
  EXPECT_EQ(tiles.store.part(0).payload_bytes, 4);
}

TEST(TilesTest, NoiseGoesRawInFullPackets) {
  const Raster raster{.stream = Stream::kDepth, .width = 640, .height = 48};
  Cut tiles = cut(picture<std::uint16_t>(raster, 1, 9), raster, true);
  for (std::size_t i = 0; i < tiles.store.size(); ++i) {
    EXPECT_EQ(tiles.store.part(i).codec, Codec::kRaw16);
  }
  EXPECT_EQ(tiles.store.size(), raw_tiles(640, 48, 2));
}

}  // namespace
}  // namespace stof::wire

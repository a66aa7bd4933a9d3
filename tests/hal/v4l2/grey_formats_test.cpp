#include "hal/linux/v4l2/grey_formats.h"

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using namespace hal::linux;  // NOLINT(google-build-using-namespace): what is tested
using Bytes = std::vector<std::uint8_t>;

Bytes grey(FourCc format, const Bytes& row, std::size_t width) {
  Bytes out(width);
  to_grey(format, row, out);
  return out;
}

std::vector<std::uint16_t> samples(FourCc format, const Bytes& row, std::size_t width) {
  std::vector<std::uint16_t> out(width);
  to_samples(format, row, out);
  return out;
}

TEST(GreyFormats, NamesAreTheKernels) {
  EXPECT_EQ(kGrey, 0x59455247U);  // V4L2_PIX_FMT_GREY
  EXPECT_EQ(kY10, 0x20303159U);
  EXPECT_EQ(kY12p, 0x50323159U);
  EXPECT_EQ(hal::linux::to_string(kYuyv), "YUYV");
  EXPECT_EQ(hal::linux::to_string(kY10), "Y10");
  EXPECT_EQ(hal::linux::to_string(0x0141U), "A...");
}

TEST(GreyFormats, RowsHaveTheBytesOfTheirPixels) {
  EXPECT_EQ(row_bytes(kGrey, 7), 7U);
  EXPECT_EQ(row_bytes(kY10, 7), 14U);
  EXPECT_EQ(row_bytes(kY12p, 8), 12U);
  EXPECT_EQ(row_bytes(kY12p, 7), 0U);
  EXPECT_EQ(row_bytes(kYuyv, 7), 0U);
  EXPECT_EQ(row_bytes(kGrey, -1), 0U);
  EXPECT_EQ(row_bytes(fourcc("MJPG"), 8), 0U);
}

TEST(GreyFormats, DeepPixelsLoseTheirLowBitsAndSaturate) {
  const Bytes row{0x00, 0x00, 0x03, 0x00, 0x04, 0x00, 0xFF, 0x03, 0x00, 0x04, 0xFF, 0xFF};
  EXPECT_EQ(grey(kY10, row, 6), (Bytes{0, 0, 1, 255, 255, 255}));
  EXPECT_EQ(grey(kY12, row, 6), (Bytes{0, 0, 0, 0x3F, 0x40, 255}));
  EXPECT_EQ(grey(kY16, row, 6), (Bytes{0, 0, 0, 3, 4, 255}));
}

TEST(GreyFormats, YuyvGivesItsBrightness) {
  EXPECT_EQ(grey(kYuyv, {1, 99, 2, 98, 3, 97, 255, 0}, 4), (Bytes{1, 2, 3, 255}));
}

// MIPI CSI-2's RAW12: A[11:4] B[11:4] B[3:0]A[3:0].
TEST(GreyFormats, Y12pUnpacksAsMipiPacksIt) {
  EXPECT_EQ(samples(kY12p, {0x12, 0xAB, 0xC3, 0xFF, 0x00, 0x0F}, 4),
            (std::vector<std::uint16_t>{0x123, 0xABC, 0xFFF, 0x000}));
}

TEST(GreyFormats, SamplesOfTwoBytesStayAsTheyAre) {
  EXPECT_EQ(samples(kY12, {0x34, 0x12, 0xFF, 0x0F}, 2),
            (std::vector<std::uint16_t>{0x1234, 0xFFF}));
  EXPECT_EQ(samples(kY16, {0x34, 0xF2}, 1), (std::vector<std::uint16_t>{0xF234}));
}

TEST(GreyFormats, EveryLengthIsConvertedAndNothingElse) {
  for (std::size_t width = 0; width <= 70; width += 2) {
    Bytes row(2 * width);
    for (std::size_t i = 0; i < row.size(); ++i) {
      row[i] = static_cast<std::uint8_t>(i * 37 % 256);
    }
    for (const FourCc format : {kGrey, kY10, kY12, kY16, kYuyv}) {
      const Bytes out = grey(format, row, width);
      for (std::size_t x = 0; x < width; ++x) {
        const int deep = row[2 * x] | row[2 * x + 1] << 8;
        const int expected = format == kGrey   ? row[x]
                             : format == kYuyv ? row[2 * x]
                             : format == kY10  ? std::min(deep / 4, 255)
                             : format == kY12  ? std::min(deep / 16, 255)
                                               : deep / 256;
        ASSERT_EQ(out[x], expected) << hal::linux::to_string(format) << " pixel " << x;
      }
    }
  }
}

}  // namespace
}  // namespace stof::test

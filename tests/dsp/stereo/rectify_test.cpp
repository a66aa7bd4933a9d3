#include "dsp/stereo/rectify.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/remap_table.h"
#include "tests/dsp/stereo/raw_world.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

// The places of one row.
struct Places {
  explicit Places(std::size_t n) : x(n), y(n), fraction_x(n), fraction_y(n) {}
  RemapRow row() const { return {x.span(), y.span(), fraction_x.span(), fraction_y.span()}; }
  test::GuardedBuffer<std::uint16_t> x, y;
  test::GuardedBuffer<std::uint8_t> fraction_x, fraction_y;
};

TEST(RemapRow, MixesFourPixelsByTheFractions) {
  // 10 20 / 40 80, a quarter to the right, three quarters down: 12.5 and 50, so 40.625.
  std::vector<std::uint8_t> pixels{10, 20, 99, 40, 80, 99};
  const ImageView<const std::uint8_t> source(pixels.data(), 2, 2, 3);
  Places places(3);
  const auto put = [&](std::size_t i, int fx, int fy) {
    places.fraction_x[i] = static_cast<std::uint8_t>(fx);
    places.fraction_y[i] = static_cast<std::uint8_t>(fy);
  };
  put(0, 32, 96);
  put(1, 32 + kPlaceInside, 96);  // the mark of the mask is not a fraction
  put(2, 0, 0);
  std::vector<std::uint8_t> out(3);
  ref::remap_row(source, places.row(), out);
  EXPECT_EQ(out, (std::vector<std::uint8_t>{41, 41, 10}));
}

TEST(RemapRow, IsWithinHalfAGreyLevelOfExactMixing) {
  std::vector<std::uint8_t> pixels(4);
  const ImageView<const std::uint8_t> source(pixels.data(), 2, 2);
  Places places(1);
  std::vector<std::uint8_t> out(1);
  double worst = 0;
  for (const auto& corners : {std::array<std::uint8_t, 4>{0, 255, 255, 0},
                              {255, 0, 0, 255},
                              {0, 0, 255, 255},
                              {255, 255, 255, 255},
                              {3, 200, 17, 90}}) {
    std::ranges::copy(corners, pixels.begin());
    for (int fx = 0; fx < kPlaceOne; ++fx) {
      for (int fy = 0; fy < kPlaceOne; ++fy) {
        places.fraction_x[0] = static_cast<std::uint8_t>(fx);
        places.fraction_y[0] = static_cast<std::uint8_t>(fy);
        ref::remap_row(source, places.row(), out);
        const double x = fx / 128.0;
        const double y = fy / 128.0;
        const double exact = (1 - y) * ((1 - x) * corners[0] + x * corners[1]) +
                             y * ((1 - x) * corners[2] + x * corners[3]);
        worst = std::max(worst, std::abs(out[0] - exact));
      }
    }
  }
  EXPECT_LE(worst, 0.5 + 0.5 / 128);
}

TEST(RemapRow, NeonEqualsReferenceForEveryLengthAndPlace) {
  for (std::size_t n = 0; n <= 70; ++n) {
    for (const auto& [w, h, stride] :
         {std::array{2, 2, 2}, {2, 9, 5}, {17, 2, 17}, {300, 7, 333}}) {
      test::Random random(n * 1000 + static_cast<std::size_t>(w));
      test::GuardedImage<std::uint8_t> source(w, h, stride);
      for (int y = 0; y < h; ++y) {
        random.fill(source.view().row(y));
        if (y % 3 == 0) {  // the largest steps between neighbours
          random.fill(source.view().row(y), 0, 1);
          for (std::uint8_t& p : source.view().row(y)) {
            p = p == 0 ? 0 : 255;
          }
        }
      }
      Places places(n);
      random.fill(places.x.span(), 0, w - 2);
      random.fill(places.y.span(), 0, h - 2);
      random.fill(places.fraction_x.span());
      random.fill(places.fraction_y.span(), 0, kPlaceOne - 1);
      test::GuardedBuffer<std::uint8_t> reference(n), neon(n);
      ref::remap_row(source.view(), places.row(), reference.span());
      neon::remap_row(source.view(), places.row(), neon.span());
      ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span()))
          << n << " of " << w << "x" << h;
    }
  }
}

// A smooth picture through the table of a real rotation and distortion, against the same picture
// looked up where double arithmetic says.
TEST(RemapTable, IsWithinAGreyLevelOfDoubleArithmetic) {
  const RawPair pair = raw::raw_pair(160, 120, 0.1);
  const Rectification rectified = rectify(pair);
  const SourceMap map(pair.left, rectified.left_turn, rectified.left);
  const auto smooth = [](double u, double v) {
    return 128 + 60 * std::sin(u / 5) + 50 * std::cos(v / 6 + u / 40);
  };
  test::GuardedImage<std::uint8_t> source(160, 120, 160);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      source.view().at(u, v) = static_cast<std::uint8_t>(std::lround(smooth(u, v)));
    }
  }
  test::GuardedImage<std::uint16_t> x(160, 120, 160), y(160, 120, 160);
  test::GuardedImage<std::uint8_t> fx(160, 120, 160), fy(160, 120, 160);
  const RemapTable table{x.view(), y.view(), fx.view(), fy.view()};
  fill_remap_table(map, table);
  std::vector<std::uint8_t> out(160);
  double worst = 0;
  for (int v = 0; v < 120; ++v) {
    best::remap_row(source.view(), table.row(v), out);
    for (int u = 0; u < 160; ++u) {
      const SourceMap::Place place = map.at(u, v);
      const int at_x = std::min(static_cast<int>(place.u), 158);
      const int at_y = std::min(static_cast<int>(place.v), 118);
      const double rest_x = place.u - at_x;
      const double rest_y = place.v - at_y;
      const auto pixel = [&](int i, int j) { return source.view().at(at_x + i, at_y + j); };
      const double exact = (1 - rest_y) * ((1 - rest_x) * pixel(0, 0) + rest_x * pixel(1, 0)) +
                           rest_y * ((1 - rest_x) * pixel(0, 1) + rest_x * pixel(1, 1));
      worst = std::max(worst, std::abs(out[static_cast<std::size_t>(u)] - exact));
      EXPECT_EQ((fx.view().at(u, v) & kPlaceInside) != 0, place.inside) << u << ", " << v;
    }
  }
  EXPECT_LT(worst, 1.0);
}

TEST(RemapTable, OfACameraThatStandsStraightCopiesThePicture) {
  const Pinhole lens{.width = 9, .height = 5, .fx = 8, .fy = 8, .cx = 4, .cy = 2};
  const SourceMap map(lens, {1, 0, 0, 0, 1, 0, 0, 0, 1}, lens);
  test::GuardedImage<std::uint16_t> x(9, 5, 9), y(9, 5, 9);
  test::GuardedImage<std::uint8_t> fx(9, 5, 9), fy(9, 5, 9);
  const RemapTable table{x.view(), y.view(), fx.view(), fy.view()};
  fill_remap_table(map, table);
  test::GuardedImage<std::uint8_t> source(9, 5, 11);
  for (int v = 0; v < 5; ++v) {
    for (int u = 0; u < 9; ++u) {
      source.view().at(u, v) = static_cast<std::uint8_t>(10 * u + v);
    }
  }
  for (int v = 0; v < 5; ++v) {
    std::vector<std::uint8_t> out(9);
    best::remap_row(source.view(), table.row(v), out);
    EXPECT_TRUE(std::ranges::equal(out, source.view().row(v))) << v;
    EXPECT_TRUE(std::ranges::all_of(table.fraction_x.row(v),
                                    [](std::uint8_t f) { return (f & kPlaceInside) != 0; }));
  }
}

}  // namespace
}  // namespace stof::dsp

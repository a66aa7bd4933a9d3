#include "dsp/stereo/rectify/rectify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/index.h"
#include "dsp/calib/stereo/remap_table.h"
#include "tests/dsp/stereo/raw_pair_scene.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

TEST(RemapMix, MixesFourPixelsByTheFractions) {
  // 10 20 / 40 80, a quarter to the right, three quarters down: 12.5 and 50, so 40.625.
  std::vector<std::uint8_t> pixels{10, 20, 99, 40, 80, 99};
  const ImageView<const std::uint8_t> source(pixels.data(), 2, 2, 3);
  EXPECT_EQ(mix(source, {.fraction_x = 32, .fraction_y = 96}), 41);
  EXPECT_EQ(mix(source, {}), 10);
}

TEST(RemapMix, IsWithinHalfAGreyLevelOfExactMixing) {
  std::vector<std::uint8_t> pixels(4);
  const ImageView<const std::uint8_t> source(pixels.data(), 2, 2);
  double worst = 0;
  for (const auto& corners : {std::array<std::uint8_t, 4>{0, 255, 255, 0},
                              {255, 0, 0, 255},
                              {0, 0, 255, 255},
                              {255, 255, 255, 255},
                              {3, 200, 17, 90}}) {
    std::ranges::copy(corners, pixels.begin());
    for (int fx = 0; fx < kPlaceOne; ++fx) {
      for (int fy = 0; fy < kPlaceOne; ++fy) {
        const int mixed = mix(source, {.fraction_x = static_cast<std::uint8_t>(fx),
                                       .fraction_y = static_cast<std::uint8_t>(fy)});
        const double x = fx / 128.0;
        const double y = fy / 128.0;
        const double exact = (1 - y) * ((1 - x) * corners[0] + x * corners[1]) +
                             y * ((1 - x) * corners[2] + x * corners[3]);
        worst = std::max(worst, std::abs(mixed - exact));
      }
    }
  }
  EXPECT_LE(worst, 0.5 + 0.5 / 128);
}

// Places that stand still, move along, bend or are spread all over a picture of this size.
PlacePatch random_patch(test::Random& random, int width, int height) {
  const int wildness = random.between(0, 3);
  const auto amount = [&](double most) { return most * random.between(-1000, 1000) / 1000.0; };
  PlacePatch patch;
  patch.x = static_cast<std::uint16_t>(random.between(0, width - 2));
  patch.y = static_cast<std::uint16_t>(random.between(0, height - 2));
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double slope =
        (axis == 0 ? 1 : 0) +
        amount(std::array{0.01, 0.3, 1.0, 3.0}[static_cast<std::size_t>(wildness)]);
    const auto set = [&](std::size_t power, std::size_t i, double value) {
      patch.powers[power][4 * axis + i] = static_cast<float>(value);
    };
    constexpr double kPixel = 128 * 65536;
    set(0, 0, kPixel * amount(20));
    set(0, 1, kPixel * slope);
    set(0, 2, kPatchBias + amount(wildness * 8000));
    set(0, 3, kPatchBias + amount(wildness * 8000));
    set(1, 0, kPixel * ((axis == 1 ? 16 : 0) + amount(8)));
    set(2, 0, kPixel * amount(2));
    set(3, 0, kPixel * amount(1));
    set(1, 1, kPixel * amount(0.02));
    set(2, 2, amount(300));
    set(3, 3, amount(300));
    const int corner = axis == 0 ? patch.x : patch.y;
    const int size = axis == 0 ? width : height;
    patch.low[axis] = static_cast<std::int16_t>(-corner * kPlaceOne);
    patch.high[axis] = static_cast<std::int16_t>((size - 1 - corner) * kPlaceOne - 1);
  }
  patch.serves = random.between(0, 9) != 0;
  return patch;
}

TEST(RemapRow, EqualsReferenceForEveryLengthAndPlace) {
  for (const auto& [w, h] : {std::array{2, 2}, {15, 9}, {16, 2}, {17, 3}, {33, 64}, {200, 150}}) {
    for (const int line : {0, 15, 16, 31}) {
      test::check_kernel(std::span(test::kHostileLengths).subspan(1), [&](test::KernelCase& c) {
        const auto source = c.image<std::uint8_t>(w, h);
        for (int y = 0; y < h; y += 3) {  // the largest steps between neighbours
          c.fill(source.row(y), 0, 1);
          for (std::uint8_t& p : source.row(y)) {
            p = p == 0 ? 0 : 255;
          }
        }
        const auto patches = c.array<PlacePatch>((c.length() + kPatchSide - 1) / kPatchSide);
        for (PlacePatch& patch : patches) {
          patch = random_patch(c.random(), w, h);
        }
        const auto out = c.array<std::uint8_t>(c.length());
        c.run([&] { best::remap_row(source, patches, line, out); });
      });
    }
  }
}

TEST(RemapRow, LeavesPixelsOfPatchesThatDoNotServe) {
  test::GuardedImage<std::uint8_t> source(40, 40, 40, 9);
  std::array<PlacePatch, 2> patches{};
  std::vector<std::uint8_t> out(64, 5);
  best::remap_row(source.view(), patches, 0, out);
  EXPECT_TRUE(std::ranges::all_of(out, [](std::uint8_t p) { return p == 5; }));
}

struct Table {
  explicit Table(const SourceMap& map)
      : owned([&](Arena& arena) { return RemapTable(map, arena); }) {}
  test::GuardedPart<RemapTable> owned;
  RemapTable& table = *owned;
};

// To the nearest 1/128 px; never on the last column or row.
Place exact(const SourceMap& map, int u, int v) {
  const SourceMap::Place place = map.at(u, v);
  const auto steps = [](double at, int size) {
    return std::min(static_cast<int>(std::lround(at * 128)), (size - 1) * 128 - 1);
  };
  const int x = steps(place.u, map.raw().width);
  const int y = steps(place.v, map.raw().height);
  return {.x = static_cast<std::uint16_t>(x / 128),
          .y = static_cast<std::uint16_t>(y / 128),
          .fraction_x = static_cast<std::uint8_t>(x % 128),
          .fraction_y = static_cast<std::uint8_t>(y % 128)};
}

struct Lens {
  const char* name;
  int width;
  int height;
  double focal;  // widths
  double k1;
  double k2;
  std::array<double, 3> turn;
  bool gentle;  // no patch is computed anew each time
};
constexpr std::array kLenses{Lens{"usual", 320, 240, 0.9, -0.24, 0.07, {0.015, 0.03, -0.02}, true},
                             Lens{"usual VGA", 640, 480, 0.8, -0.2, 0.05, {0.01, 0.02, 0.01}, true},
                             Lens{"wide", 640, 480, 0.5, -0.35, 0.15, {0.01, 0.03, 0.01}, true},
                             Lens{"wider", 640, 480, 0.44, -0.3, 0.09, {0.01, 0.03, 0.01}, true},
                             Lens{"pincushion", 333, 250, 0.9, 0.2, 0.2, {0.01, 0.03, 0.01}, false},
                             Lens{"turned", 320, 240, 0.9, -0.2, 0.05, {0.3, 0.4, 0.35}, true},
                             Lens{"small", 161, 121, 0.9, -0.24, 0.07, {0.015, 0.35, -0.02}, true},
                             Lens{"folds", 200, 150, 0.5, -0.7, 0.0, {0.02, 0.3, 0.1}, false},
                             Lens{"tiny", 5, 3, 0.9, -0.2, 0.0, {0.0, 0.0, 0.0}, false},
                             Lens{"mad", 96, 80, 0.3, 3.0, -2.0, {0.3, 0.8, 0.3}, false}};

RawPair pair_of(const Lens& lens) {
  RawPair pair = raw::raw_pair(lens.width, lens.height);
  for (Pinhole* const camera : {&pair.left, &pair.right}) {
    camera->fx = camera->fy = lens.focal * lens.width;
    camera->k1 = lens.k1;
    camera->k2 = lens.k2;
  }
  pair.left_to_right.rotation = raw::turned(lens.turn[0], lens.turn[1], lens.turn[2]);
  return pair;
}

TEST(RemapTable, TellsThePlaceOfEveryPixelOfEveryLensExactly) {
  int computed = 0;
  for (const Lens& lens : kLenses) {
    SCOPED_TRACE(lens.name);
    const RawPair pair = pair_of(lens);
    const Rectification rectified = rectify(pair);
    const SourceMap map(pair.right, rectified.right_turn, rectified.right);
    const Table tested(map);
    test::Random random(1);
    test::GuardedImage<std::uint8_t> source(lens.width, lens.height, lens.width + 3);
    for (int v = 0; v < lens.height; ++v) {
      random.fill(source.view().row(v));
    }
    test::GuardedBuffer<std::uint8_t> out(static_cast<std::size_t>(lens.width));
    for (int v = 0; v < lens.height; ++v) {
      std::ranges::fill(out.span(), std::uint8_t{0});
      tested.table.remap(source.view(), v, out.span());
      for (int u = 0; u < lens.width; ++u) {
        const Place want = exact(map, u, v);
        ASSERT_EQ(tested.table.place(u, v), want) << u << ", " << v;
        ASSERT_EQ(out[static_cast<std::size_t>(u)], mix(source.view(), want)) << u << ", " << v;
      }
    }
    computed += tested.table.computed_patches();
    EXPECT_EQ(tested.table.computed_patches() == 0, lens.gentle);
  }
  EXPECT_GT(computed, 0);  // both ways were tried
}

TEST(RemapTable, TellsWhatTheCameraSaw) {
  int torn = 0;
  for (const Lens& lens : kLenses) {
    SCOPED_TRACE(lens.name);
    const RawPair pair = pair_of(lens);
    const Rectification rectified = rectify(pair);
    const SourceMap map(pair.left, rectified.left_turn, rectified.left);
    const Table tested(map);
    for (int v = 0; v < lens.height; ++v) {
      const RemapTable::Seen seen = tested.table.seen(v);
      int count = 0;
      for (int u = 0; u < lens.width; ++u) {
        const bool inside = map.at(u, v).inside;
        ASSERT_EQ(tested.table.inside(u, v), inside);
        ASSERT_TRUE(!inside || (u >= seen.begin && u < seen.end));
        count += inside ? 1 : 0;
      }
      ASSERT_EQ(seen.torn, count < seen.end - seen.begin) << v;
      torn += seen.torn ? 1 : 0;
    }
  }
  EXPECT_GT(torn, 0);  // rows with gaps were looked at
}

TEST(RemapTable, TakesLessThanHalfAByteAPixel) {
  for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1280, 720}}) {
    const RawPair pair = raw::raw_pair(width, height, 0);
    const Rectification rectified = rectify(pair);
    const SourceMap map(pair.left, rectified.left_turn, rectified.left);
    EXPECT_LE(bytes_taken([&](Arena& arena) { RemapTable(map, arena); }),
              index(width * height * 42 / 100));
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
  const Table tested(map);
  std::vector<std::uint8_t> out(160);
  double worst = 0;
  for (int v = 0; v < 120; ++v) {
    tested.table.remap(source.view(), v, out);
    for (int u = 0; u < 160; ++u) {
      const SourceMap::Place place = map.at(u, v);
      const int at_x = std::min(static_cast<int>(place.u), 158);
      const int at_y = std::min(static_cast<int>(place.v), 118);
      const double rest_x = place.u - at_x;
      const double rest_y = place.v - at_y;
      const auto pixel = [&](int i, int j) { return source.view().at(at_x + i, at_y + j); };
      const double want = (1 - rest_y) * ((1 - rest_x) * pixel(0, 0) + rest_x * pixel(1, 0)) +
                          rest_y * ((1 - rest_x) * pixel(0, 1) + rest_x * pixel(1, 1));
      worst = std::max(worst, std::abs(out[static_cast<std::size_t>(u)] - want));
    }
  }
  EXPECT_LT(worst, 1.0);
}

TEST(RemapTable, OfACameraThatStandsStraightCopiesThePicture) {
  for (const auto& [w, h] : {std::array{9, 5}, {70, 40}}) {
    const Pinhole lens{.width = w, .height = h, .fx = 8, .fy = 8, .cx = 4, .cy = 2};
    const Table tested(SourceMap(lens, {1, 0, 0, 0, 1, 0, 0, 0, 1}, lens));
    test::GuardedImage<std::uint8_t> source(w, h, w + 2);
    test::Random random(7);
    for (int v = 0; v < h; ++v) {
      random.fill(source.view().row(v));
    }
    for (int v = 0; v < h; ++v) {
      // The last column and row are mixed from 1/128 px before them: equal neighbours.
      source.view().at(w - 1, v) = source.view().at(w - 2, v);
    }
    std::ranges::copy(source.view().row(h - 2), source.view().row(h - 1).begin());
    for (int v = 0; v < h; ++v) {
      std::vector<std::uint8_t> out(static_cast<std::size_t>(w));
      tested.table.remap(source.view(), v, out);
      EXPECT_TRUE(std::ranges::equal(out, source.view().row(v))) << v;
      const RemapTable::Seen seen = tested.table.seen(v);
      EXPECT_TRUE(seen.begin == 0 && seen.end == w && !seen.torn);
    }
  }
}

}  // namespace
}  // namespace stof::dsp

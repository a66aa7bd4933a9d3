#include "hal/emu/imagery/lens_rays.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "hal/emu/imagery/grey.h"
#include "hal/emu/imagery/pmd_samples.h"
#include "hal/emu/imagery/soften.h"

namespace stof::test {
namespace {

using namespace hal::emu;

constexpr dsp::Pinhole kBent{.width = 640,
                             .height = 480,
                             .fx = 612.5,
                             .fy = 613.25,
                             .cx = 322.25,
                             .cy = 236.5,
                             .k1 = -0.2125,
                             .k2 = 0.0875,
                             .k3 = 0.0125,
                             .p1 = 0.0011,
                             .p2 = -0.0007};

// The model written out once more, in the order of OpenCV's documentation: k1 k2 p1 p2 k3.
std::array<double, 2> by_formula(const dsp::Pinhole& lens, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + lens.k1 * r2 + lens.k2 * std::pow(r2, 2) + lens.k3 * std::pow(r2, 3);
  const double xd = x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x);
  const double yd = y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y;
  return {lens.fx * xd + lens.cx, lens.fy * yd + lens.cy};
}

// Numbers computed with another program.
TEST(LensRays, ProjectIsTheWorkedExample) {
  const PicturePoint first = project(kBent, 0.3, -0.2);
  EXPECT_NEAR(first.u, 500.98691029687495, 1e-9);
  EXPECT_NEAR(first.v, 117.246643036875, 1e-9);
  const PicturePoint second = project(kBent, -0.5, 0.36);
  EXPECT_NEAR(second.u, 36.013256726994996, 1e-9);
  EXPECT_NEAR(second.v, 442.98155347713896, 1e-9);
}

TEST(LensRays, ComeBackToTheirPixelToABillionthOfOne) {
  dsp::Pinhole barrel = kBent;
  barrel.k1 = -0.35;
  barrel.k2 = 0.14;
  barrel.k3 = -0.02;
  barrel.p1 = 0.004;
  barrel.p2 = -0.003;
  // A real camera's: bends outwards by a third, where x <- x_d / stretch turns in circles.
  const dsp::Pinhole pincushion{.width = 224,
                                .height = 172,
                                .fx = 124.34428,
                                .fy = 124.34428,
                                .cx = 111.5,
                                .cy = 85.5,
                                .k1 = 0.309874,
                                .k2 = -0.143910,
                                .k3 = 0.186653};
  for (const dsp::Pinhole& lens : {kBent, barrel, pincushion}) {
    for (double v = -0.5; v < lens.height; v += 7.25) {
      for (double u = -0.5; u < lens.width; u += 7.25) {
        const Vec3 ray = undistorted_ray(lens, u, v);
        const auto back = by_formula(lens, ray.x, ray.y);
        ASSERT_NEAR(back[0], u, 1e-9);
        ASSERT_NEAR(back[1], v, 1e-9);
      }
    }
    EXPECT_TRUE(shows_each_place_once(lens));
  }
}

TEST(LensRays, WithinAPixelAreRightToAThousandthOfOne) {
  const LensRays rays(kBent);
  for (int y = 0; y < kBent.height; y += 11) {
    for (int x = 0; x < kBent.width; x += 11) {
      const Vec3 centre = rays.at(x, y);
      const auto back = by_formula(kBent, centre.x, centre.y);
      ASSERT_NEAR(back[0], x, 1e-9);
      ASSERT_NEAR(back[1], y, 1e-9);
      const Vec3 beside = rays.at(x + 0.49, y - 0.5);
      const auto there = by_formula(kBent, beside.x, beside.y);
      ASSERT_NEAR(there[0], x + 0.49, 1e-3);
      ASSERT_NEAR(there[1], y - 0.5, 1e-3);
      const Viewpoint::Window window = rays.window(x, y);
      ASSERT_TRUE(window.holds(beside.x, beside.y) && window.holds(centre.x, centre.y));
    }
  }
}

TEST(LensRays, OfALensWithoutDistortionAreItsOwnBits) {
  dsp::Pinhole lens = kBent;
  lens.k1 = lens.k2 = lens.k3 = lens.p1 = lens.p2 = 0;
  const LensRays rays(lens);
  EXPECT_TRUE(rays.centres().empty());
  const Vec3 ray = rays.at(17.25, 300.5);
  EXPECT_EQ(ray.x, (17.25 - lens.cx) / lens.fx);
  EXPECT_EQ(ray.y, (300.5 - lens.cy) / lens.fy);
}

TEST(LensRays, KnowALensThatFolds) {
  dsp::Pinhole lens = kBent;
  lens.k1 = -1.2;
  lens.k2 = lens.k3 = 0;
  EXPECT_FALSE(shows_each_place_once(lens));
}

// A straight edge of a print bends as the formula says, in every row.
TEST(RenderGrey, StraightEdgesBendByTheFormula) {
  dsp::Pinhole lens = kBent;
  lens.width = 320;
  lens.height = 240;
  lens.fx /= 2;
  lens.fy /= 2;
  lens.cx /= 2;
  lens.cy /= 2;
  const Print half{.columns = 2, .rows = 1, .cell_m = 8, .cells = {0, 255}};
  for (const double edge : {-0.42, 0.1, 0.4}) {
    Scene scene;
    scene.ambient = 0.5;
    add(scene, Shape::kRectangle, {2 * edge, 0, 2}, {8, 4, 0},
        {.albedo = 1, .contrast = 1, .texture = Texture::kPrint, .print = &half});
    const auto picture =
        render_grey(scene, Viewpoint(scene, {}), LensRays(lens), {.gain = 200, .black = 0});
    double worst = 0;
    double square = 0;
    for (int row = 0; row < lens.height; ++row) {
      double dark = 0;
      for (const std::uint16_t level : picture.view().row(row)) {
        dark += 1 - level / (100.0 * (1 << kGreyBits));
      }
      double low = -2;  // where on the edge the row is
      double high = 2;
      for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (by_formula(lens, edge, middle)[1] < row ? low : high) = middle;
      }
      const double miss = dark - 0.5 - by_formula(lens, edge, low)[0];
      worst = std::max(worst, std::abs(miss));
      square += miss * miss / lens.height;
    }
    EXPECT_LT(worst, 0.03) << edge;
    EXPECT_LT(std::sqrt(square), 0.01) << edge;
  }
}

TEST(Bell, IsTheExponentialFunction) {
  for (const double x : {0.0, 0.3, 1.0, 2.5, 4.0, 9.0}) {
    EXPECT_NEAR(bell(x, 0.8) / std::exp(-x * x / (2 * 0.64)), 1, 1e-11) << x;
  }
}

// A point becomes a Gaussian of that standard deviation, and no light is lost.
TEST(Soften, SpreadsAPoint) {
  for (const double sigma : {0.3, 0.6, 1.0, 1.7}) {
    dataset::Image<std::uint16_t> picture(41, 31);
    picture.view().at(20, 15) = 64000;
    soften({.blur_px = sigma}, 0, picture);
    double sum = 0;
    double across = 0;
    double down = 0;
    for (int y = 0; y < 31; ++y) {
      for (int x = 0; x < 41; ++x) {
        const double light = picture.view().at(x, y);
        sum += light;
        across += light * (x - 20) * (x - 20);
        down += light * (y - 15) * (y - 15);
      }
    }
    EXPECT_NEAR(sum / 64000, 1, 0.01) << sigma;
    EXPECT_NEAR(across / sum, sigma * sigma, 0.02 * sigma * sigma) << sigma;
    EXPECT_NEAR(down / sum, sigma * sigma, 0.02 * sigma * sigma) << sigma;
  }
}

TEST(Soften, LeavesFlatPicturesAndThoseOfSharpLensesAlone) {
  dataset::Image<std::uint16_t> flat(20, 12, 12345);
  soften({.blur_px = 2}, 4, flat);
  EXPECT_TRUE(std::ranges::all_of(flat.pixels, [](std::uint16_t v) { return v == 12345; }));
  dataset::Image<std::uint16_t> any(20, 12);
  for (std::size_t i = 0; i < any.pixels.size(); ++i) {
    any.pixels[i] = static_cast<std::uint16_t>(i * 131);
  }
  const dataset::Image<std::uint16_t> before = any;
  soften({}, 4, any);
  EXPECT_EQ(any.pixels, before.pixels);
}

TEST(Soften, DarkensTheCornersByTheirShare) {
  dataset::Image<std::uint16_t> flat(21, 11, 104 << kGreyBits);
  soften({.vignetting = 0.4}, 4, flat);
  EXPECT_EQ(flat.view().at(10, 5), 104 << kGreyBits);
  EXPECT_EQ(flat.view().at(0, 0), 64 << kGreyBits);
  EXPECT_EQ(flat.view().at(20, 10), 64 << kGreyBits);
  // (8/10)^2 10^2 of 10^2 + 5^2: 0.512 of the corner's.
  EXPECT_NEAR(flat.view().at(18, 5) / 128.0, 4 + 100 * (1 - 0.4 * 0.512), 0.01);
}

TEST(PmdRays, OfABlurredPixelHaveItsVariance) {
  const dsp::Pinhole lens{.width = 3, .height = 3, .fx = 1, .fy = 1, .cx = 1, .cy = 1};
  for (const double sigma : {0.3, 0.8, 1.5}) {
    const std::vector<Vec3> rays = pmd_rays(lens, 8, sigma);
    double mean = 0;
    double square = 0;
    for (std::size_t i = 0; i < 64; ++i) {  // the middle pixel, at (0, 0)
      mean += rays[4 * 64 + i].x / 64;
      square += rays[4 * 64 + i].x * rays[4 * 64 + i].x / 64;
    }
    EXPECT_NEAR(mean, 0, 1e-9);
    EXPECT_NEAR(square, 1.0 / 12 + sigma * sigma, 1e-9);
  }
}

TEST(PmdRays, ScatteredOnesFillEachPixelEvenlyAndInPlacesOfItsOwn) {
  const dsp::Pinhole lens{.width = 40, .height = 1, .fx = 1, .fy = 1};
  const std::vector<Vec3> rays = pmd_rays(lens, 8, 0, RayPlaces::kScattered);
  ASSERT_EQ(rays.size(), 40U * 64U);
  const std::vector<Vec3> grid = pmd_rays(lens, 8);
  double worst_in_grid = 0;
  double square = 0;
  for (std::size_t pixel = 0; pixel < 40; ++pixel) {
    // An edge that is nearly upright: how much of the pixel lies to the left of it.
    const auto left_of = [&](const std::vector<Vec3>& all, double edge) {
      double share = 0;
      for (std::size_t i = 0; i < 64; ++i) {
        const Vec3& ray = all[pixel * 64 + i];
        EXPECT_LE(std::abs(ray.x - static_cast<double>(pixel)), 0.5);
        EXPECT_LE(std::abs(ray.y), 0.5);
        share += ray.x - static_cast<double>(pixel) < edge + 0.01 * ray.y ? 1.0 / 64 : 0;
      }
      return share;
    };
    for (double edge = -0.45; edge < 0.45; edge += 0.03) {
      const double off = left_of(rays, edge) - (edge + 0.5);
      EXPECT_LT(std::abs(off), 0.03);
      square += off * off / (40 * 30);
      worst_in_grid = std::max(worst_in_grid, std::abs(left_of(grid, edge) - (edge + 0.5)));
    }
  }
  EXPECT_LT(std::sqrt(square), 0.01);
  EXPECT_GT(worst_in_grid, 0.05);
  EXPECT_NE(rays[0].x, rays[64].x - 1);
  EXPECT_EQ(pmd_rays(lens, 8, 0, RayPlaces::kScattered)[77].x, rays[77].x);
}

TEST(PmdRays, ScatteredOnesOfABlurredPixelHaveItsVariance) {
  const dsp::Pinhole lens{.width = 50, .height = 1, .fx = 1, .fy = 1};
  for (const double sigma : {0.3, 1.5}) {
    const std::vector<Vec3> rays = pmd_rays(lens, 8, sigma, RayPlaces::kScattered);
    double square = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double x = rays[i].x - static_cast<double>(i / 64);
      square += x * x / static_cast<double>(rays.size());
    }
    EXPECT_NEAR(square / (1.0 / 12 + sigma * sigma), 1, 0.03);
  }
}

}  // namespace
}  // namespace stof::test

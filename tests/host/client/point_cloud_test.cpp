#include "host/client/frame/point_cloud.h"

#include <vector>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

// 3 x 2 pixels, f = 2 px, centre at (1, 0.5).
struct Scene {
  std::vector<dsp::QuarterMm> depth{0, 4000, 8000, 65535, 0, 1};
  std::vector<dsp::QuarterMm> width{0, 40, 80, 0, 0, 2};
  std::vector<dsp::Source> source{dsp::Source::kConflict, dsp::Source::kStereo,
                                  dsp::Source::kPmd,      dsp::Source::kBoth,
                                  dsp::Source::kNone,     dsp::Source::kResolved};
  std::vector<std::uint8_t> received = std::vector<std::uint8_t>(6, 7);
  Frame frame{.depth = {depth.data(), 3, 2},
              .interval_width = {width.data(), 3, 2},
              .source = {source.data(), 3, 2},
              .received = {received.data(), 3, 2},
              .info = {},
              .calibration = wire::CalibrationPacket{.image_width = 3,
                                                     .image_height = 2,
                                                     .fx = 2 << 16,
                                                     .fy = 4 << 16,
                                                     .cx = 1 << 16,
                                                     .cy = 1 << 15}};
};

TEST(PointCloud, PutsEveryDepthWhereItsPixelLooks) {
  const Scene scene;
  std::vector<Point> points(99);
  ASSERT_EQ(point_cloud(scene.frame, points), Status::kOk);
  ASSERT_EQ(points.size(), 4U);
  // Pixel (1, 0), 1 m: straight ahead in x, half a pixel above the centre.
  EXPECT_FLOAT_EQ(points[0].x, 0.0F);
  EXPECT_FLOAT_EQ(points[0].y, -0.125F);
  EXPECT_FLOAT_EQ(points[0].z, 1.0F);
  EXPECT_FLOAT_EQ(points[0].z_width, 0.01F);
  EXPECT_EQ(points[0].source, dsp::Source::kStereo);
  // Pixel (2, 0), 2 m.
  EXPECT_FLOAT_EQ(points[1].x, 1.0F);
  EXPECT_FLOAT_EQ(points[1].y, -0.25F);
  EXPECT_FLOAT_EQ(points[1].z, 2.0F);
  // Pixel (0, 1), the farthest depth.
  EXPECT_FLOAT_EQ(points[2].z, 16.38375F);
  EXPECT_FLOAT_EQ(points[2].x, -16.38375F / 2);
  EXPECT_FLOAT_EQ(points[2].y, 16.38375F / 8);
  EXPECT_FLOAT_EQ(points[2].z_width, 0.0F);
  EXPECT_FLOAT_EQ(points[3].z, 0.00025F);
}

TEST(PointCloud, FollowsTheDepthUnit) {
  Scene scene;
  scene.frame.calibration->depth_unit_um = 1000;
  std::vector<Point> points;
  ASSERT_EQ(point_cloud(scene.frame, points), Status::kOk);
  EXPECT_FLOAT_EQ(points[0].z, 4.0F);
  EXPECT_FLOAT_EQ(points[0].z_width, 0.04F);
}

TEST(PointCloud, AWidthThatDidNotArriveIsUnknownNotZero) {
  Scene scene;
  scene.received[1] = kHasDepth | kHasSource;
  std::vector<Point> points;
  ASSERT_EQ(point_cloud(scene.frame, points), Status::kOk);
  EXPECT_EQ(points[0].z_width, kUnknownWidth);
}

TEST(PointCloud, NeedsTheCalibrationOfItsImage) {
  Scene scene;
  std::vector<Point> points(1);
  scene.frame.calibration->image_width = 4;
  EXPECT_EQ(point_cloud(scene.frame, points), Status::kInvalidArgument);
  EXPECT_TRUE(points.empty());
  scene.frame.calibration.reset();
  EXPECT_EQ(point_cloud(scene.frame, points), Status::kUnsupported);
}

}  // namespace
}  // namespace stof::client

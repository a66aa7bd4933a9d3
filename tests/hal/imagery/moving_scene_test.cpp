#include "hal/emu/imagery/moving_scene.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "hal/emu/imagery/rendered_scene.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using namespace hal::emu;

constexpr std::uint32_t kRound = 120;  // exposures

MovingScene& small_walk() {
  static MovingScene scene(walking(), small(corridor_rig()));
  return scene;
}

void expect_equal(const Exposed& a, const Exposed& b, std::uint32_t number) {
  EXPECT_EQ(a.left.pixels, b.left.pixels) << number;
  EXPECT_EQ(a.right.pixels, b.right.pixels) << number;
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(a.samples[k].pixels, b.samples[k].pixels) << number << " sample " << k;
  }
}

// Nothing of a pose is missing, and nothing of another is left over, in whatever order they come.
TEST(MovingScene, ShowsWhatItsSceneWouldShowAlone) {
  for (const std::uint32_t number : {1U, 60U, 4U, 5003U, 1U}) {
    RenderedScene still(small_walk().scene(number), small(corridor_rig()));
    expect_equal(expose(small_walk(), number), expose(still, number), number);
    EXPECT_EQ(small_walk().depth(number).pixels, still.depth().pixels) << number;
    EXPECT_EQ(small_walk().visible(number).pixels, still.visible().pixels) << number;
  }
}

TEST(MovingScene, IsSeenThroughAPane) {
  Motion motion{.background = wall(4), .poses = {}, .exposures_per_pose = 1};
  add(motion.background, Shape::kRectangle, {0, -1, 1}, {5, 5, 0},
      {.albedo = 0.05, .transmittance = 0.8});
  for (const double x : {-0.5, 0.5}) {
    motion.poses.push_back({{.pose = {.position = {x, -1, 3}}, .half = {0.3, 0.3, 0.3}}});
  }
  MovingScene moving(motion, small(corridor_rig()));
  for (const std::uint32_t number : {1U, 2U}) {
    RenderedScene still(moving.scene(number), small(corridor_rig()));
    expect_equal(expose(moving, number), expose(still, number), number);
  }
  EXPECT_NE(expose(moving, 1).left.pixels, expose(moving, 2).left.pixels);
}

TEST(MovingScene, ViewsMayBeAskedForInAnyOrder) {
  const Exposed far = expose(small_walk(), 2);
  const Exposed near = expose(small_walk(), 61);
  Exposed mixed = near;
  small_walk().left(2, mixed.left.view());
  small_walk().pmd(61, 3, mixed.samples[3].view());
  small_walk().pmd(2, 0, mixed.samples[0].view());
  small_walk().right(61, mixed.right.view());
  EXPECT_EQ(mixed.left.pixels, far.left.pixels);
  EXPECT_EQ(mixed.right.pixels, near.right.pixels);
  EXPECT_EQ(mixed.samples[0].pixels, far.samples[0].pixels);
  EXPECT_EQ(mixed.samples[3].pixels, near.samples[3].pixels);
}

TEST(MovingScene, GoesRoundWithNewNoise) {
  EXPECT_EQ(small_walk().depth(7).pixels, small_walk().depth(7 + kRound).pixels);
  EXPECT_NE(expose(small_walk(), 7).left.pixels, expose(small_walk(), 7 + kRound).left.pixels);
  EXPECT_NE(small_walk().depth(7).pixels, small_walk().depth(7 + kRound / 2).pixels);
}

TEST(MovingScene, SparsePmdCameraSeesThePoseOfItsOwnEdge) {
  Motion motion = walking();
  motion.poses.resize(12);
  motion.pmd_every = 4;
  MovingScene sparse(motion, small(corridor_rig()));
  for (const std::uint32_t number : {1U, 2U, 12U}) {
    RenderedScene still(sparse.scene((number - 1) * 4 + 1), small(corridor_rig()));
    const Exposed exposed = expose(sparse, number);
    const Exposed expected = expose(still, number);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(exposed.samples[k].pixels, expected.samples[k].pixels) << number;
    }
  }
}

TEST(MovingScene, WorksWithoutPmdCamera) {
  Rig rig = small(corridor_rig());
  rig.pmd_lens = {};
  Motion motion = walking();
  motion.poses.resize(2);
  MovingScene scene(motion, rig);
  EXPECT_EQ(scene.pmd_size(), Size{});
  dataset::Image<std::uint8_t> left(160, 120);
  scene.left(1, left.view());
  EXPECT_EQ(left.pixels, expose(small_walk(), 1).left.pixels);
}

TEST(Walking, SomebodyIsSeenInEveryPoseWithinTheSearchRange) {
  const RenderedScene empty(empty_corridor(), small(corridor_rig()));
  float near = 100;
  float far = 0;
  for (std::uint32_t number = 0; number < kRound; number += 3) {
    const dataset::Image<float> depth = small_walk().depth(number);
    int pixels = 0;
    float nearest = 100;
    for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
      const bool person = depth.pixels[i] != empty.depth().pixels[i];
      pixels += person ? 1 : 0;
      nearest = person ? std::min(nearest, depth.pixels[i]) : nearest;
    }
    EXPECT_GT(pixels, static_cast<int>(depth.pixels.size() / 100)) << number;
    near = std::min(near, nearest);
    far = std::max(far, nearest);
  }
  EXPECT_GT(near, 2.0F);
  EXPECT_LT(near, 2.8F);
  EXPECT_GT(far, 4.5F);
}

TEST(Walking, GivesTheSameBitsOnEveryMachine) {
  EXPECT_EQ(hash(expose(small_walk(), 61)), 7953651522127901166ULL);
}

// The truth of `leaving` is another where the box was, then where the door was, and only there.
TEST(MovingScene, ThingsLeave) {
  const MovingScene scene(leaving(), small(corridor_rig()));
  const auto farther = [&](std::uint32_t now, std::uint32_t before) {
    const dataset::Image<float> a = scene.depth(now);
    const dataset::Image<float> b = scene.depth(before);
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      EXPECT_GE(a.pixels[i], b.pixels[i]);
      count += a.pixels[i] > b.pixels[i] + 0.5F ? 1U : 0U;
    }
    return static_cast<double>(count) / static_cast<double>(a.pixels.size());
  };
  EXPECT_EQ(scene.depth(11).pixels, scene.depth(0).pixels);
  EXPECT_GT(farther(12, 11), 0.02);
  EXPECT_EQ(scene.depth(23).pixels, scene.depth(12).pixels);
  const dataset::Image<float> closed = scene.depth(23);
  const dataset::Image<float> open = scene.depth(24);
  std::size_t behind = 0;
  for (std::size_t i = 0; i < open.pixels.size(); ++i) {
    behind += open.pixels[i] > closed.pixels[i] + 0.5F ? 1U : 0U;
  }
  EXPECT_GT(behind, open.pixels.size() / 50);
}

}  // namespace
}  // namespace stof::test

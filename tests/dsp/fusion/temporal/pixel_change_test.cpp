#include "dsp/fusion/temporal/pixel_change.h"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

TEST(PixelChange, IsMoreThanTwelveLevelsInEitherDirection) {
  const std::array<std::uint8_t, 6> now{0, 255, 10, 112, 113, 87};
  std::array<std::uint8_t, 6> then{255, 0, 14, 100, 100, 100};
  std::array<std::uint8_t, 6> changed{};
  best::pixel_change(now, then, changed);
  EXPECT_EQ(changed, (std::array<std::uint8_t, 6>{255, 255, 0, 0, 255, 255}));
  EXPECT_EQ(then, (std::array<std::uint8_t, 6>{0, 255, 14, 100, 113, 87}));
}

TEST(PixelChange, EqualsReferenceForEveryLength) {
  test::check_kernel([](test::KernelCase& c) {
    const int most = c.length() % 2 == 0 ? 255 : 30;
    const auto now = c.array<std::uint8_t>(c.length(), 0, most);
    const auto then = c.array<std::uint8_t>(c.length(), 0, most);
    const auto changed = c.array<std::uint8_t>(c.length());
    c.run([&] { best::pixel_change(now, then, changed); });
  });
}

}  // namespace
}  // namespace stof::dsp

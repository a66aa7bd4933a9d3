#include "dsp/stereo/prefilter/equalise.h"

#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;

using Pixels = std::vector<std::uint8_t>;

ImageView<const std::uint8_t> view(const Pixels& pixels) {
  return {pixels.data(), kWidth, kHeight};
}

Pixels textured(std::uint64_t seed) {
  Pixels pixels(kWidth * kHeight);
  test::Random random(seed);
  random.fill(std::span(pixels), 20, 220);
  return pixels;
}

TEST(Equalise, AnEqualPictureStaysAsItIs) {
  const Pixels picture = textured(1);
  const GreyTable table = equalising_table(view(picture), view(picture));
  for (std::size_t v = 0; v < table.size(); ++v) {
    EXPECT_NEAR(table[v], static_cast<int>(v), 1);
  }
}

TEST(Equalise, UndoesADarkerExposure) {
  const Pixels model = textured(2);
  Pixels dark = model;
  for (std::uint8_t& grey : dark) {
    grey = static_cast<std::uint8_t>(std::lround(0.5 * grey + 7));
  }
  const GreyTable table = equalising_table(view(dark), view(model));
  Pixels equalised(dark.size());
  apply_table(table, view(dark), {0, kHeight}, {equalised.data(), kWidth, kHeight});
  for (std::size_t i = 0; i < model.size(); ++i) {
    ASSERT_NEAR(equalised[i], model[i], 3);
  }
}

TEST(Equalise, LeavesFlatPicturesAlone) {
  const Pixels flat(kWidth * kHeight, 90);
  for (const GreyTable& table :
       {equalising_table(view(flat), view(textured(3))),
        equalising_table(view(textured(3)), view(flat)), equalising_table({}, {})}) {
    for (std::size_t v = 0; v < table.size(); ++v) {
      ASSERT_EQ(table[v], v);
    }
  }
}

TEST(Equalise, AmplifiesNoMoreThanFourTimes) {
  Pixels faint(kWidth * kHeight, 100);
  faint[0] = 101;
  const GreyTable table = equalising_table(view(faint), view(textured(4)));
  EXPECT_LE(std::abs(table[101] - table[100]), 4);
}

TEST(Equalise, AppliesToTheRowsAskedForAndNoOthers) {
  const Pixels picture = textured(5);
  Pixels out(picture.size(), 3);
  GreyTable table{};
  table.fill(8);
  apply_table(table, view(picture), {10, 12}, {out.data(), kWidth, kHeight});
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t y = i / kWidth;
    ASSERT_EQ(out[i], y == 10 || y == 11 ? 8 : 3);
  }
}

}  // namespace
}  // namespace stof::dsp

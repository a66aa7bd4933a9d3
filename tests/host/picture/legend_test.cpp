#include "host/picture/legend.h"

#include <gtest/gtest.h>

namespace stof::host {
namespace {

constexpr Rgb kWhite{255, 255, 255};

TEST(DrawText, DrawsDigitsAsTheyAreReadAndCutsWhatLiesOutside) {
  dataset::Image<Rgb> picture(5, 7);
  draw_text(picture, 0, 3, "1", kWhite);
  std::string seen;
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 5; ++x) {
      seen += picture.view().at(x, y) == kWhite ? '#' : '.';
    }
    seen += '\n';
  }
  EXPECT_EQ(seen, "..#..\n.##..\n..#..\n..#..\n..#..\n..#..\n.###.\n");
  for (const auto& [x, y] : {std::pair{-3, 3}, {4, 3}, {0, -2}, {0, 8}, {-100, 100}}) {
    draw_text(picture, x, y, "0123456789.% m near far none?", kWhite);  // the sanitizers watch
  }
}

TEST(DrawText, IsAsWideAsItSays) {
  EXPECT_EQ(text_width(""), 0);
  EXPECT_EQ(text_width("8"), 5);
  EXPECT_EQ(text_width("1.5 m"), 29);
}

}  // namespace
}  // namespace stof::host

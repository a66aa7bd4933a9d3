#include "host/picture/legend.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "host/picture/source_colours.h"

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

TEST(Legend, HasASwatchAndAWordForEachSource) {
  std::array<std::pair<Rgb, std::string_view>, kSourceColours.size()> entries;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i] = {kSourceColours[i], kSourceWords[i]};
  }
  const Rgb map_colour{1, 2, 3};
  const dataset::Image<Rgb> map(20, 4, map_colour);
  const dataset::Image<Rgb> picture = with_swatches(map, entries);
  EXPECT_EQ(picture.width, map.width + kLegendWidth);
  EXPECT_EQ(picture.view().at(19, 3), map_colour);
  const Rgb panel = picture.view().at(picture.width - 1, picture.height - 1);
  for (const Rgb colour : kSourceColours) {
    int first = picture.height;
    for (int y = picture.height - 1; y >= 0; --y) {
      first = picture.view().at(map.width + 10, y) == colour ? y : first;
    }
    ASSERT_LT(first, picture.height - 8) << "no swatch";
    // Its word: letters from the swatch to before the edge, cut nowhere.
    int inked = 0;
    int last = 0;
    for (int y = first; y < first + 11; ++y) {
      for (int x = map.width + 24; x < picture.width; ++x) {
        const bool ink = !(picture.view().at(x, y) == panel);
        inked += ink ? 1 : 0;
        last = ink ? std::max(last, x) : last;
      }
    }
    EXPECT_GT(inked, 30);
    EXPECT_LT(last, picture.width - 1);
  }
}

TEST(Legend, KnowsTheLettersOfEverySource) {
  for (const std::string_view word : kSourceWords) {
    for (const char letter : word) {
      dataset::Image<Rgb> picture(5, 7);
      draw_text(picture, 0, 3, std::string_view(&letter, 1), kWhite);
      EXPECT_NE(std::ranges::count(picture.pixels, kWhite), 0) << letter;
    }
  }
}

}  // namespace
}  // namespace stof::host

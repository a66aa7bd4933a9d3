#include "host/picture/legend.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stof::host {
namespace {

constexpr Rgb kPanel{24, 26, 30};
constexpr Rgb kInk{222, 224, 228};
constexpr int kMinHeight = 96;

// A margin, the bar, ticks, their texts; "none" has its own box below the bar.
constexpr int kMargin = 14;
constexpr int kBarWidth = 18;
constexpr int kTick = 5;
constexpr int kNoneBox = 14;

// Six swatches fit the lowest picture.
constexpr int kSwatchMargin = 8;
constexpr int kSwatchHeight = 11;
constexpr int kSwatchStep = 15;

constexpr int kGlyphWidth = 5;
constexpr int kGlyphHeight = 7;

// Seven rows of five pixels, the leftmost in bit 4.
struct Glyph {
  char character;
  std::array<std::uint8_t, kGlyphHeight> rows;
};
constexpr std::array<Glyph, 31> kGlyphs{{
    {'0', {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110}},
    {'1', {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'2', {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111}},
    {'3', {0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110}},
    {'4', {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', {0b11111, 0b00001, 0b00010, 0b00100, 0b00100, 0b01000, 0b01000}},
    {'8', {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100}},
    {'.', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100}},
    {'m', {0b00000, 0b00000, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101}},
    {'n', {0b00000, 0b00000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001}},
    {'o', {0b00000, 0b00000, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'a', {0b00000, 0b00000, 0b01110, 0b00001, 0b01111, 0b10001, 0b01111}},
    {'f', {0b00110, 0b01001, 0b01000, 0b11100, 0b01000, 0b01000, 0b01000}},
    {'r', {0b00000, 0b00000, 0b10110, 0b11001, 0b10000, 0b10000, 0b10000}},
    {'%', {0b11000, 0b11001, 0b00010, 0b00100, 0b01000, 0b10011, 0b00011}},
    {'e', {0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110}},
    {'s', {0b00000, 0b00000, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110}},
    {'t', {0b01000, 0b01000, 0b11100, 0b01000, 0b01000, 0b01001, 0b00110}},
    {'b', {0b10000, 0b10000, 0b10110, 0b11001, 0b10001, 0b10001, 0b11110}},
    {'h', {0b10000, 0b10000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001}},
    {'l', {0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'v', {0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100}},
    {'d', {0b00001, 0b00001, 0b01101, 0b10011, 0b10001, 0b10001, 0b01111}},
    {'c', {0b00000, 0b00000, 0b01110, 0b10000, 0b10000, 0b10001, 0b01110}},
    {'i', {0b00100, 0b00000, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'P', {0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'M', {0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001}},
    {'D', {0b11100, 0b10010, 0b10001, 0b10001, 0b10001, 0b10010, 0b11100}},
}};

void put(dataset::Image<Rgb>& picture, int x, int y, Rgb colour) {
  if (x >= 0 && x < picture.width && y >= 0 && y < picture.height) {
    picture.view().at(x, y) = colour;
  }
}

dataset::Image<Rgb> with_panel(const dataset::Image<Rgb>& map) {
  dataset::Image<Rgb> picture(map.width + kLegendWidth, std::max(map.height, kMinHeight), kPanel);
  for (int y = 0; y < map.height; ++y) {
    std::ranges::copy(map.view().row(y), picture.view().row(y).begin());
  }
  return picture;
}

void draw(dataset::Image<Rgb>& picture, int left, const Legend& legend) {
  const int bar_left = left + kMargin;
  const int bar_right = bar_left + kBarWidth;
  const int top = kMargin;
  const int bottom = picture.height - kMargin - kNoneBox - kMargin / 2;
  const double span = bottom - 1 - top;
  for (int y = top; y < bottom; ++y) {
    for (int x = bar_left; x < bar_right; ++x) {
      put(picture, x, y, legend.colour((y - top) / span));
    }
  }
  int free_from = 0;
  for (const auto& [place, text] : legend.ticks) {
    const int y = top + static_cast<int>(std::lround(place * span));
    if (y - kGlyphHeight < free_from) {
      continue;  // no room on a low picture
    }
    free_from = y + kGlyphHeight / 2 + 1;
    for (int x = bar_right; x < bar_right + kTick; ++x) {
      put(picture, x, y, kInk);
    }
    draw_text(picture, bar_right + kTick + 3, y, text, kInk);
  }
  const int box_top = picture.height - kMargin - kNoneBox;
  for (int y = 0; y < kNoneBox; ++y) {
    for (int x = 0; x < kBarWidth; ++x) {
      put(picture, bar_left + x, box_top + y, legend.none(x, y));
    }
  }
  draw_text(picture, bar_right + kTick + 3, box_top + kNoneBox / 2, "none", kInk);
}

}  // namespace

int text_width(std::string_view text) {
  return static_cast<int>(text.size()) * (kGlyphWidth + 1) - (text.empty() ? 0 : 1);
}

void draw_text(dataset::Image<Rgb>& picture, int x, int y, std::string_view text, Rgb colour) {
  for (const char character : text) {
    const auto* const glyph = std::ranges::find(kGlyphs, character, &Glyph::character);
    for (int row = 0; glyph != kGlyphs.end() && row < kGlyphHeight; ++row) {
      for (int column = 0; column < kGlyphWidth; ++column) {
        const int bit = kGlyphWidth - 1 - column;
        if ((glyph->rows[static_cast<std::size_t>(row)] >> bit & 1) != 0) {
          put(picture, x + column, y - kGlyphHeight / 2 + row, colour);
        }
      }
    }
    x += kGlyphWidth + 1;
  }
}

dataset::Image<Rgb> with_legend(const dataset::Image<Rgb>& map, const Legend& legend) {
  dataset::Image<Rgb> picture = with_panel(map);
  draw(picture, map.width, legend);
  return picture;
}

dataset::Image<Rgb> with_swatches(const dataset::Image<Rgb>& map,
                                  std::span<const std::pair<Rgb, std::string_view>> entries) {
  dataset::Image<Rgb> picture = with_panel(map);
  const int left = map.width + kSwatchMargin;
  int top = kSwatchMargin / 2;
  for (const auto& [colour, word] : entries) {
    for (int y = 0; y < kSwatchHeight; ++y) {
      for (int x = 0; x < kNoneBox; ++x) {
        put(picture, left + x, top + y, colour);
      }
    }
    draw_text(picture, left + kNoneBox + kTick, top + kSwatchHeight / 2, word, kInk);
    top += kSwatchStep;
  }
  return picture;
}

}  // namespace stof::host

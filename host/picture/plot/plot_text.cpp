#include "host/picture/plot/plot_text.h"

#include <array>

namespace stof::host {
namespace {

constexpr int kColumns = 5;
constexpr int kRows = 9;
constexpr int kAdvance = kColumns + 1;

// Nine rows from top to bottom; each is a digit of base 32 (0 .. 9, A .. V), the leftmost dot its
// highest bit.
struct Letter {
  char name;
  std::string_view rows;
};
constexpr std::array kLetters = std::to_array<Letter>(
    {{' ', "000000000"}, {'%', "PQ248BJ00"}, {'(', "248884200"}, {')', "842224800"},
     {'*', "04LEL4000"}, {'+', "044V44000"}, {',', "00000CC48"}, {'-', "000V00000"},
     {'.', "00000CC00"}, {'/', "122488G00"}, {'0', "EHJLPHE00"}, {'1', "4C4444E00"},
     {'2', "EH1248V00"}, {'3', "EH161HE00"}, {'4', "26AIV2200"}, {'5', "VGU11HE00"},
     {'6', "EGGUHHE00"}, {'7', "V12448800"}, {'8', "EHHEHHE00"}, {'9', "EHHF11E00"},
     {':', "0CC0CC000"}, {'=', "00V0V0000"}, {'?', "EH1240400"}, {'A', "EHHVHHH00"},
     {'B', "UHHUHHU00"}, {'C', "EHGGGHE00"}, {'D', "UHHHHHU00"}, {'E', "VGGUGGV00"},
     {'F', "VGGUGGG00"}, {'G', "EHGNHHF00"}, {'H', "HHHVHHH00"}, {'I', "E44444E00"},
     {'J', "72222IC00"}, {'K', "HIKOKIH00"}, {'L', "GGGGGGV00"}, {'M', "HRLLHHH00"},
     {'N', "HPLJHHH00"}, {'O', "EHHHHHE00"}, {'P', "UHHUGGG00"}, {'Q', "EHHHLID00"},
     {'R', "UHHUKIH00"}, {'S', "FGGE11U00"}, {'T', "V44444400"}, {'U', "HHHHHHE00"},
     {'V', "HHHHHA400"}, {'W', "HHHLLRH00"}, {'X', "HHA4AHH00"}, {'Y', "HHA444400"},
     {'Z', "V1248GV00"}, {'^', "4AH000000"}, {'_', "000000V00"}, {'a', "00E1FHF00"},
     {'b', "GGUHHHU00"}, {'c', "00EHGHE00"}, {'d', "11FHHHF00"}, {'e', "00EHVGE00"},
     {'f', "698S88800"}, {'g', "00FHHHF1E"}, {'h', "GGMPHHH00"}, {'i', "40C444E00"},
     {'j', "2062222IC"}, {'k', "GGIKOKI00"}, {'l', "C44444E00"}, {'m', "00QLLLL00"},
     {'n', "00MPHHH00"}, {'o', "00EHHHE00"}, {'p', "00UHHHUGG"}, {'q', "00FHHHF11"},
     {'r', "00MPGGG00"}, {'s', "00FGE1U00"}, {'t', "88S889600"}, {'u', "00HHHJD00"},
     {'v', "00HHHA400"}, {'w', "00HHLLA00"}, {'x', "00HA4AH00"}, {'y', "00HHHHF1E"},
     {'z', "00V248V00"}});

constexpr int digit(char c) noexcept { return c <= '9' ? c - '0' : c - 'A' + 10; }

constexpr std::string_view rows_of(char name) noexcept {
  std::string_view unknown;
  for (const Letter& letter : kLetters) {
    if (letter.name == name) {
      return letter.rows;
    }
    if (letter.name == '?') {
      unknown = letter.rows;
    }
  }
  return unknown;
}

void dot(dataset::Image<Rgb>& picture, int x, int y, Rgb colour) {
  for (int v = y; v < y + kLabelDot; ++v) {
    for (int u = x; u < x + kLabelDot; ++u) {
      if (u >= 0 && u < picture.width && v >= 0 && v < picture.height) {
        picture.view().row(v)[static_cast<std::size_t>(u)] = colour;
      }
    }
  }
}

// Calls visit(column, row) of every dot that is set, in dots from the upper left corner.
template <typename Visit>
void for_each_dot(std::string_view text, const Visit& visit) {
  int left = 0;
  for (const char c : text) {
    const std::string_view rows = rows_of(c);
    for (int row = 0; row < kRows; ++row) {
      const int bits = digit(rows[static_cast<std::size_t>(row)]);
      for (int column = 0; column < kColumns; ++column) {
        if (bits / (1 << (kColumns - 1 - column)) % 2 == 1) {
          visit(left + column, row);
        }
      }
    }
    left += kAdvance;
  }
}

}  // namespace

int label_width(std::string_view text) noexcept {
  return text.empty() ? 0 : (static_cast<int>(text.size()) * kAdvance - 1) * kLabelDot;
}

void draw_label(dataset::Image<Rgb>& picture, int x, int y, std::string_view text, Rgb colour) {
  for_each_dot(text, [&](int column, int row) {
    dot(picture, x + column * kLabelDot, y + row * kLabelDot, colour);
  });
}

void draw_label_upwards(dataset::Image<Rgb>& picture, int x, int y, std::string_view text,
                        Rgb colour) {
  for_each_dot(text, [&](int column, int row) {
    dot(picture, x + row * kLabelDot, y - (column + 1) * kLabelDot, colour);
  });
}

}  // namespace stof::host

#include "host/calibrate/rig/target/target_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "dataset/files/file.h"
#include "host/calibrate/rig/target/marker_finder.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kMillimetres = 1000;
constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kRulerMm = 14;  // the height that ruler and text take below the board
constexpr double kMarginMm = 5;  // that printers leave white
constexpr double kTextMm = 3.2;
constexpr double kTickMm = 0.2;

struct Paper {
  std::string_view name;
  double short_mm;
  double long_mm;
};
constexpr std::array<Paper, 5> kPapers{
    {{"a4", 210, 297}, {"a3", 297, 420}, {"a2", 420, 594}, {"a1", 594, 841}, {"a0", 841, 1189}}};

// What is printed of a board, without the white around it, in sides of a square or tag. Its first
// corner is `margin` right and below of its upper left end.
struct Outline {
  double width;
  double height;
  double margin;
};

Outline outline_of(const Board& board) {
  const double margin = board.kind == Board::Kind::kAprilGrid ? board.share : 1;
  const std::array<double, 2> last = board.at(board.corners() - 1);
  return {.width = last[0] / board.square_m + 2 * margin,
          .height = last[1] / board.square_m + 2 * margin,
          .margin = margin};
}

// Rectangles in sides of a square or tag, from the outline's upper left end.
struct Pattern {
  std::vector<Rectangle> black;
  std::vector<Rectangle> white;
};

void add_markers(const Board& board, Pattern& pattern) {
  const double margin = outline_of(board).margin;
  const double side = marker_side_m(board) / board.square_m;
  for (const BoardMarker& marker : markers_of(board)) {
    const double x = marker.x_m / board.square_m + margin;
    const double y = marker.y_m / board.square_m + margin;
    pattern.black.push_back({x, y, side, side});
    const MarkerCells cells = cells_of(board, marker.id);
    const double cell = side / cells.side;
    for (int row = 0; row < cells.side; ++row) {
      for (int column = 0; column < cells.side; ++column) {
        if (!cells.black[static_cast<std::size_t>(row * cells.side + column)]) {
          pattern.white.push_back({x + column * cell, y + row * cell, cell, cell});
        }
      }
    }
  }
}

Pattern pattern_of(const Board& board) {
  Pattern pattern;
  if (board.kind == Board::Kind::kAprilGrid) {
    // Small squares where the gaps cross, around the outermost tags too.
    const double step = 1 + board.share;
    for (int row = 0; row <= board.rows / 2; ++row) {
      for (int column = 0; column <= board.columns / 2; ++column) {
        pattern.black.push_back({column * step, row * step, board.share, board.share});
      }
    }
  } else {
    // One more square than corners; the one right and below of the first corner is black.
    for (int row = 0; row <= board.rows; ++row) {
      for (int column = 0; column <= board.columns; ++column) {
        if ((row + column) % 2 == 0) {
          pattern.black.push_back({static_cast<double>(column), static_cast<double>(row), 1, 1});
        }
      }
    }
  }
  add_markers(board, pattern);
  return pattern;
}

Rectangle scaled(const Rectangle& r, double side, double x, double y) {
  return {x + r.x_mm * side, y + r.y_mm * side, r.width_mm * side, r.height_mm * side};
}

void add_board(const Board& board, double x, double y, Sheet& sheet) {
  const double side = board.square_m * kMillimetres;
  const Pattern pattern = pattern_of(board);
  for (const Rectangle& r : pattern.black) {
    sheet.black.push_back(scaled(r, side, x, y));
  }
  for (const Rectangle& r : pattern.white) {
    sheet.white.push_back(scaled(r, side, x, y));
  }
}

void fill(const Rectangle& r, std::uint8_t grey, dataset::Image<std::uint8_t>& picture) {
  const auto last = [](double begin, double size) {
    return static_cast<int>(std::lround(begin + size));
  };
  for (int y = last(r.y_mm, 0); y < last(r.y_mm, r.height_mm); ++y) {
    for (int x = last(r.x_mm, 0); x < last(r.x_mm, r.width_mm); ++x) {
      picture.view().at(x, y) = grey;
    }
  }
}

bool is_whole(double value) { return std::abs(value - std::round(value)) < 1e-6; }

void add_ruler(double x, double y, double length, Sheet& sheet) {
  constexpr double kCentimetre = 10;
  const int whole = static_cast<int>(length / kCentimetre) * 10;
  sheet.black.push_back({x, y, static_cast<double>(whole), kTickMm});
  for (int mm = 0; mm <= whole; ++mm) {
    const double tick = 2 + (mm % 5 == 0 ? 1 : 0) + (mm % 10 == 0 ? 1 : 0);
    sheet.black.push_back({x + mm - kTickMm / 2, y, kTickMm, tick});
    if (mm % 50 == 0) {
      sheet.texts.push_back({x + mm + 0.5, y + 4 + kTextMm, kTextMm, std::to_string(mm)});
    }
  }
}

std::string escaped_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '(' || c == ')' || c == '\\') {
      out += '\\';
    }
    out += c;
  }
  return out;
}

std::string content_of(const Sheet& sheet) {
  const auto up = [&sheet](double y_mm) { return (sheet.height_mm - y_mm) * kPointsPerMm; };
  std::string content = "0 g\n";
  const auto add = [&](const std::vector<Rectangle>& rectangles) {
    for (const Rectangle& r : rectangles) {
      content +=
          printed("%.4f %.4f %.4f %.4f re\n", r.x_mm * kPointsPerMm, up(r.y_mm + r.height_mm),
                  r.width_mm * kPointsPerMm, r.height_mm * kPointsPerMm);
    }
    content += "f\n";
  };
  add(sheet.black);
  if (!sheet.white.empty()) {
    content += "1 g\n";
    add(sheet.white);
    content += "0 g\n";
  }
  for (const SheetText& t : sheet.texts) {
    content += printed("BT /F1 %.3f Tf %.4f %.4f Td (%s) Tj ET\n", t.size_mm * kPointsPerMm,
                       t.x_mm * kPointsPerMm, up(t.y_mm), escaped_text(t.text).c_str());
  }
  return content;
}

}  // namespace

dataset::Loaded<Sheet> sheet_of(const Board& board, std::string_view paper) {
  const auto* const found = std::ranges::find(kPapers, paper, &Paper::name);
  if (found == kPapers.end()) {
    return dataset::refuse("paper " + std::string(paper) +
                           ": is not known: use a4, a3, a2, a1 or a0");
  }
  const double side = board.square_m * kMillimetres;
  const double width = outline_of(board).width * side;
  const double height = outline_of(board).height * side;
  Sheet sheet{.width_mm = found->short_mm, .height_mm = found->long_mm};
  if (width > height) {
    std::swap(sheet.width_mm, sheet.height_mm);
  }
  const double spare_x = sheet.width_mm - width;
  const double spare_y = sheet.height_mm - height - kRulerMm;
  // White around the board is part of it: half a square is the least that finders want.
  const double white = std::max(side / 2, kMarginMm);
  if (spare_x < 2 * white || spare_y < 2 * white) {
    return dataset::refuse(
        printed("board %s: takes %.0f x %.0f mm with its margins, %s is %.0f x "
                "%.0f mm: use larger paper or smaller squares",
                to_string(board).c_str(), width + 2 * white, height + 2 * white + kRulerMm,
                found->name.data(), sheet.width_mm, sheet.height_mm));
  }
  const double x = spare_x / 2;
  const double y = spare_y / 2;
  add_board(board, x, y, sheet);
  const double below = sheet.height_mm - kRulerMm;
  add_ruler(x, below, std::min(width, sheet.width_mm - x - kMarginMm - 10), sheet);
  sheet.texts.push_back(
      {x, below + 12, kTextMm,
       printed(
           "stof board %s: print at 100 percent, measure: the ruler is in millimetres, a %s is %g "
           "mm",
           to_string(board).c_str(), board.kind == Board::Kind::kAprilGrid ? "tag" : "square",
           side)});
  return sheet;
}

std::optional<BoardPicture> picture_of(const Board& board) {
  const Pattern pattern = pattern_of(board);
  const auto whole = [&pattern](double side) {
    const auto fits = [side](const Rectangle& r) {
      return is_whole(r.x_mm * side) && is_whole(r.y_mm * side) && is_whole(r.width_mm * side) &&
             is_whole(r.height_mm * side);
    };
    return std::ranges::all_of(pattern.black, fits) && std::ranges::all_of(pattern.white, fits);
  };
  constexpr int kMostPixels = 100;  // a side of a square
  int side = 1;
  while (side <= kMostPixels && !whole(side)) {
    ++side;
  }
  if (side > kMostPixels) {
    return std::nullopt;
  }
  const Outline outline = outline_of(board);
  constexpr double kWhite = 1;  // squares around it
  const auto pixels = [side](double sides) { return static_cast<int>(std::lround(sides * side)); };
  BoardPicture made{
      .picture = {pixels(outline.width + 2 * kWhite), pixels(outline.height + 2 * kWhite), 255},
      .pixel_mm = board.square_m * kMillimetres / side};
  for (const Rectangle& r : pattern.black) {
    fill(scaled(r, side, kWhite * side, kWhite * side), 0, made.picture);
  }
  for (const Rectangle& r : pattern.white) {
    fill(scaled(r, side, kWhite * side, kWhite * side), 255, made.picture);
  }
  return made;
}

std::string pdf_bytes(const Sheet& sheet) {
  const std::string content = content_of(sheet);
  const std::array<std::string, 5> objects{
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      printed(
          "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 %.4f %.4f] /Contents 5 0 R /Resources << "
          "/Font << /F1 4 0 R >> >> >>",
          sheet.width_mm * kPointsPerMm, sheet.height_mm * kPointsPerMm),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
      printed("<< /Length %zu >>\nstream\n%s\nendstream", content.size(), content.c_str())};
  std::string pdf = "%PDF-1.4\n";
  std::string table = "0000000000 65535 f \n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += printed("%010zu 00000 n \n", pdf.size());
    pdf += printed("%zu 0 obj\n", i + 1) + objects[i] + "\nendobj\n";
  }
  const std::size_t start = pdf.size();
  pdf += printed("xref\n0 %zu\n", objects.size() + 1) + table;
  pdf += printed("trailer\n<< /Size %zu /Root 1 0 R >>\nstartxref\n%zu\n%%%%EOF\n",
                 objects.size() + 1, start);
  return pdf;
}

}  // namespace stof::host

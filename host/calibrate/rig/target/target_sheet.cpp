#include "host/calibrate/rig/target/target_sheet.h"

#include <algorithm>
#include <array>
#include <utility>

#include "dataset/files/file.h"
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

void add_board(const Board& board, double x, double y, Sheet& sheet) {
  const double side = board.square_m * kMillimetres;
  // One more square than corners; the one right and below of the first corner is black.
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column) {
      if ((row + column) % 2 == 0) {
        sheet.black.push_back({x + column * side, y + row * side, side, side});
      }
    }
  }
}

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
  for (const Rectangle& r : sheet.black) {
    content += printed("%.4f %.4f %.4f %.4f re\n", r.x_mm * kPointsPerMm, up(r.y_mm + r.height_mm),
                       r.width_mm * kPointsPerMm, r.height_mm * kPointsPerMm);
  }
  content += "f\n";
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
  const double width = (board.columns + 1) * side;
  const double height = (board.rows + 1) * side;
  Sheet sheet{.width_mm = found->short_mm, .height_mm = found->long_mm, .black = {}, .texts = {}};
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
           "stof board %s: print at 100 percent, measure: the ruler is in millimetres, a square "
           "is %g mm",
           to_string(board).c_str(), side)});
  return sheet;
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

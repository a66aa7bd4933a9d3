#pragma once

#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/picture/png.h"

// The parts of one self-contained HTML page: nothing in it is fetched from anywhere.
namespace stof::host {

// Whether a claim of the chapter holds on what was measured here.
enum class Verdict : std::uint8_t { kYes, kPartly, kNo, kNotMeasured };

// kYes: all of them; kPartly: some; kNo: none; kNotMeasured: there was nothing to judge.
Verdict verdict_of(int hold, int judged);

struct Claim {
  std::string chapter;   // what the chapter says, in our words; text
  std::string measured;  // text
  std::string rule;      // when it counts as holding; text
  Verdict verdict = Verdict::kNotMeasured;
};

// A picture with its caption and, where colours mean something, their legend.
struct Figure {
  std::string picture;  // HTML: an image with its data, or a drawing
  std::string title;    // text, also what the picture is called without pictures
  std::string caption;  // text, with units
  std::string legend;   // HTML of legend.h, or empty
};
Figure figure(const dataset::Image<Rgb>& picture, std::string title, std::string caption,
              std::string legend = "");
Figure figure(const dataset::Image<std::uint8_t>& grey, std::string title, std::string caption);

// Cells are text. A row of one cell is a heading inside the table.
struct Table {
  std::string caption;
  std::vector<std::string> header;
  std::size_t text_columns = 1;  // left-aligned; the others are numbers
  std::vector<std::vector<std::string>> rows{};
};

enum class Width : std::uint8_t { kSmall, kMedium, kLarge };  // of the figures of a group

class Page {
 public:
  void begin_section(std::string id, std::string title);
  void heading(std::string_view text);
  void paragraph(std::string_view text);
  void table(const Table& table);  // left out when it has no rows
  void figures(const std::vector<Figure>& figures, Width width);
  void claim(Claim claim);

  // title and lead are text.
  std::string html(std::string_view title, const std::vector<std::string>& lead) const;
  // The claims as lines of text: verdict, claim.
  std::string verdicts() const;

 private:
  struct Section {
    std::string id;
    std::string title;
    std::vector<Claim> claims;
    std::string body;
  };
  std::vector<Section> sections_;
};

// With &, <, > and quotes made harmless.
std::string escaped(std::string_view text);
std::string base64(std::string_view bytes);
std::string css_colour(Rgb colour);

// "12.3"; "–" for what could not be counted.
std::string number(std::optional<double> value, int digits);
// part of whole; none of nothing.
template <typename T>
std::optional<double> share(T part, T whole) {
  return whole == 0 ? std::nullopt
                    : std::optional(static_cast<double>(part) / static_cast<double>(whole));
}
// 0..1 as "12.3" percent, without the sign.
std::string percent(std::optional<double> share, int digits = 1);

// Writes a page; folders that are missing are made. One line when that fails.
std::expected<void, dataset::Problem> write_page(const std::filesystem::path& file,
                                                 const std::string& html);

}  // namespace stof::host

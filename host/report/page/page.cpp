#include "host/report/page/page.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dataset/files/file.h"
#include "host/report/page/style.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

struct VerdictText {
  std::string_view css;
  std::string_view text;
};

VerdictText text_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kYes:
      return {"yes", "yes"};
    case Verdict::kPartly:
      return {"partly", "partly"};
    case Verdict::kNo:
      return {"no", "no"};
    case Verdict::kNotMeasured:
      return {"unknown", "not measured"};
  }
  return {};
}

std::string chip(Verdict verdict) {
  const VerdictText text = text_of(verdict);
  return "<span class=\"chip " + std::string(text.css) + "\">" + std::string(text.text) + "</span>";
}

std::string claim_box(const Claim& claim) {
  return "<div class=\"claim\"><dl><dt>A claim of the chapter, in our words</dt><dd>" +
         escaped(claim.chapter) + "</dd><dt>Measured here</dt><dd>" + escaped(claim.measured) +
         "</dd><dt>Holds here</dt><dd>" + chip(claim.verdict) +
         "</dd><dt>Rule</dt><dd class=\"rule\">" + escaped(claim.rule) + "</dd></dl></div>\n";
}

std::string row_of(const std::vector<std::string>& cells, const Table& table,
                   std::string_view tag) {
  std::string html = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string_view css = i < table.text_columns ? "t" : "n";
    html.append("<").append(tag).append(" class=\"").append(css).append("\">");
    html.append(escaped(cells[i])).append("</").append(tag).append(">");
  }
  return html + "</tr>\n";
}

std::string_view css_of(Width width) {
  switch (width) {
    case Width::kSmall:
      return "small";
    case Width::kMedium:
      return "medium";
    case Width::kLarge:
      return "large";
  }
  return "";
}

// The data of a PNG file in the page. Few pixels are shown as squares, not smoothed.
std::string image(const std::string& png, int width, int height, const std::string& title) {
  constexpr int kFewPixels = 256;
  return printed(R"(<img%s width="%d" height="%d" alt=")",
                 width < kFewPixels ? " class=\"pixels\"" : "", width, height) +
         escaped(title) + "\" src=\"data:image/png;base64," + base64(png) + "\">";
}

}  // namespace

Verdict verdict_of(int hold, int judged) {
  if (judged == 0) {
    return Verdict::kNotMeasured;
  }
  if (hold == judged) {
    return Verdict::kYes;
  }
  return hold == 0 ? Verdict::kNo : Verdict::kPartly;
}

Figure figure(const dataset::Image<Rgb>& picture, std::string title, std::string caption,
              std::string legend) {
  std::string html = image(png_bytes(picture), picture.width, picture.height, title);
  return {std::move(html), std::move(title), std::move(caption), std::move(legend)};
}

Figure figure(const dataset::Image<std::uint8_t>& grey, std::string title, std::string caption) {
  std::string html = image(png_bytes(grey), grey.width, grey.height, title);
  return {std::move(html), std::move(title), std::move(caption), {}};
}

void Page::begin_section(std::string id, std::string title) {
  sections_.push_back({.id = std::move(id), .title = std::move(title), .claims = {}, .body = {}});
}

void Page::heading(std::string_view text) {
  sections_.back().body += "<h3>" + escaped(text) + "</h3>\n";
}

void Page::paragraph(std::string_view text) {
  sections_.back().body += "<p>" + escaped(text) + "</p>\n";
}

void Page::table(const Table& table) {
  const bool has_content =
      std::ranges::any_of(table.rows, [](const auto& row) { return row.size() > 1; });
  if (!has_content) {
    return;
  }
  std::string html;
  if (!table.caption.empty()) {
    html += "<p class=\"caption\">" + escaped(table.caption) + "</p>\n";
  }
  html += "<div class=\"scroll\"><table>";
  html += "<thead>" + row_of(table.header, table, "th") + "</thead><tbody>\n";
  for (const std::vector<std::string>& row : table.rows) {
    if (row.size() == 1 && table.header.size() > 1) {
      html += R"(<tr class="group"><td class="t" colspan=")" + std::to_string(table.header.size()) +
              R"(">)" + escaped(row[0]) + "</td></tr>\n";
    } else {
      html += row_of(row, table, "td");
    }
  }
  sections_.back().body += html + "</tbody></table></div>\n";
}

void Page::figures(const std::vector<Figure>& figures, Width width) {
  if (figures.empty()) {
    return;
  }
  std::string html = "<div class=\"figures " + std::string(css_of(width)) + "\">\n";
  for (const Figure& figure : figures) {
    html += "<figure>" + figure.picture + figure.legend + "<figcaption><b>" +
            escaped(figure.title) + ".</b> " + escaped(figure.caption) + "</figcaption></figure>\n";
  }
  sections_.back().body += html + "</div>\n";
}

void Page::claim(Claim claim) {
  sections_.back().body += claim_box(claim);
  sections_.back().claims.push_back(std::move(claim));
}

std::string Page::html(std::string_view title, const std::vector<std::string>& lead) const {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<meta name=\"color-scheme\" content=\"light dark\"><title>" +
      escaped(title) + "</title>\n<style>" + std::string(kStyleSheet) +
      "</style></head>\n<body><header><h1>" + escaped(title) + "</h1>\n";
  for (const std::string& paragraph : lead) {
    html += "<p>" + escaped(paragraph) + "</p>\n";
  }
  html += "<nav aria-label=\"Contents\">";
  std::string claims;
  for (const Section& section : sections_) {
    const std::string link = "<a href=\"#" + section.id + "\">";
    html += link + escaped(section.title) + "</a> ";
    for (const Claim& claim : section.claims) {
      claims += "<tr><td class=\"t\">" + escaped(claim.chapter) + "</td><td class=\"t\">" +
                chip(claim.verdict) + "</td><td class=\"t\">" + link + escaped(section.title) +
                "</a></td></tr>\n";
    }
  }
  html += "</nav></header>\n<main>\n";
  if (!claims.empty()) {
    html +=
        "<section id=\"claims\"><h2>What of the chapter holds here</h2><div class=\"scroll\">"
        "<table class=\"verdicts\"><thead><tr><th class=\"t\">A claim of the chapter, in our "
        "words</th><th class=\"t\">Holds here</th><th "
        "class=\"t\">Section</th></tr></thead><tbody>" +
        claims + "</tbody></table></div></section>\n";
  }
  for (const Section& section : sections_) {
    html += "<section id=\"" + section.id + "\"><h2>" + escaped(section.title) + "</h2>\n" +
            section.body + "</section>\n";
  }
  return html + "</main></body></html>\n";
}

std::string Page::verdicts() const {
  std::string lines;
  for (const Section& section : sections_) {
    for (const Claim& claim : section.claims) {
      std::string verdict(text_of(claim.verdict).text);
      verdict.resize(std::max<std::size_t>(verdict.size(), 14), ' ');
      lines.append(verdict).append(claim.chapter).append("\n");
    }
  }
  return lines;
}

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t byte = i < count ? static_cast<std::uint8_t>(bytes[at + i]) : 0;
      group = group << 8 | byte;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      text += i <= count ? kDigits[group >> (18 - 6 * i) & 63] : '=';
    }
  }
  return text;
}

std::string css_colour(Rgb colour) {
  return printed("#%02x%02x%02x", colour.red, colour.green, colour.blue);
}

std::string number(std::optional<double> value, int digits) {
  if (!value || !std::isfinite(*value)) {
    return "–";
  }
  const std::string text = printed("%.*f", digits, *value);
  const std::string_view shown(text);
  const bool is_zero = shown.find_first_not_of("-0.") == std::string_view::npos;
  return std::string(shown.substr(is_zero && shown.starts_with('-') ? 1 : 0));
}

std::string percent(std::optional<double> share, int digits) {
  return number(share ? std::optional(100 * *share) : std::nullopt, digits);
}

std::expected<void, dataset::Problem> write_page(const std::filesystem::path& file,
                                                 const std::string& html) {
  if (file.has_parent_path()) {
    std::error_code error;  // where there is no folder, writing fails
    std::filesystem::create_directories(file.parent_path(), error);
  }
  return dataset::write_whole(file, html);
}

}  // namespace stof::host

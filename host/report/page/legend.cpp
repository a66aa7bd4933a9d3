#include "host/report/page/legend.h"

#include <algorithm>
#include <cmath>

#include "host/picture/error_picture.h"
#include "host/report/page/page.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

struct BarTick {
  double place;  // 0..1 along the bar
  std::string text;
};

// A bar of colours with ticks below, the unit at its end, and a box of "none".
// The drawing has units of its own, about half a millimetre on the screen.
std::string bar(const std::vector<Rgb>& colours, const std::vector<BarTick>& ticks,
                std::string_view unit, Rgb (*none)(int x, int y) = none_colour) {
  constexpr double kBarWidth = 216;
  constexpr double kLeft = 10;
  constexpr double kNoneLeft = kLeft + kBarWidth + 49;
  std::string svg =
      R"(<svg class="bar" viewBox="0 0 300 32" role="img" aria-label="colour scale">)";
  const double step = kBarWidth / static_cast<double>(colours.size());
  const auto rectangle = [&svg](double x, double y, double width, double height, Rgb colour) {
    svg += printed(R"(<rect x="%.2f" y="%.2f" width="%.2f" height="%.2f" fill="%s" )", x, y, width,
                   height, css_colour(colour).c_str()) +
           R"(shape-rendering="crispEdges"/>)";
  };
  for (std::size_t i = 0; i < colours.size(); ++i) {
    // A little too wide: no gaps between neighbours.
    rectangle(kLeft + static_cast<double>(i) * step, 2, step + 0.4, 10, colours[i]);
  }
  const auto text = [&svg](double x, const char* anchor, std::string_view what) {
    svg += printed(R"(<text y="28" font-size="12" fill="currentColor" x="%.1f" text-anchor="%s">)",
                   x, anchor) +
           escaped(what) + "</text>";
  };
  for (const BarTick& tick : ticks) {
    const double x = kLeft + tick.place * kBarWidth;
    svg += printed(R"(<path stroke="currentColor" d="M%.1f 12v4"/>)", x);
    const char* const inside = tick.place < 1 ? "middle" : "end";
    text(x, tick.place <= 0 ? "start" : inside, tick.text);
  }
  text(kLeft + kBarWidth + 12, "start", unit);
  constexpr int kBox = 3;
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) {
      rectangle(kNoneLeft + kBox * x, 1 + kBox * y, kBox, kBox, none(kBox * x, kBox * y));
    }
  }
  svg += printed(
      R"(<path fill="none" stroke="currentColor" stroke-width="0.6" d="M%.1f 1h18v12h-18z"/>)",
      kNoneLeft);
  text(kNoneLeft + 9, "middle", "none");
  return svg + "</svg>";
}

constexpr int kBarSteps = 48;

std::string swatch(std::string_view background, std::string_view meaning) {
  return "<span><i style=\"background:" + std::string(background) + "\"></i>" + escaped(meaning) +
         "</span>";
}

}  // namespace

std::string tick_text(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return printed("%.*f", decimals, value);
}

std::string disparity_legend(const DisparityScale& scale) {
  std::vector<Rgb> colours;
  colours.reserve(kBarSteps);
  for (int i = 0; i < kBarSteps; ++i) {
    colours.push_back(scale.colour(std::lerp(scale.far_px, scale.near_px, (i + 0.5) / kBarSteps)));
  }
  std::vector<BarTick> ticks;
  for (const double d : scale.ticks()) {
    ticks.push_back({(d - scale.far_px) / (scale.near_px - scale.far_px), number(d, 0)});
  }
  return bar(colours, ticks, "px");
}

std::string depth_legend(const ColourScale& scale) {
  dataset::Image<float> ramp(kBarSteps, 1);
  for (int i = 0; i < kBarSteps; ++i) {
    const double place = (i + 0.5) / kBarSteps;
    ramp.view().at(i, 0) =
        static_cast<float>(scale.near_m * std::pow(scale.far_m / scale.near_m, place));
  }
  std::vector<BarTick> ticks;
  for (const double z : scale.ticks()) {
    ticks.push_back({scale.position(z), printed("%g", z)});
  }
  return bar(metric_picture(ramp, scale).pixels, ticks, "m");
}

std::string error_legend(double most, std::string_view unit) {
  std::vector<Rgb> colours;
  colours.reserve(kBarSteps);
  for (int i = 0; i < kBarSteps; ++i) {
    colours.push_back(error_colour(2 * (i + 0.5) / kBarSteps - 1));
  }
  const double step = most / 50;
  const std::vector<BarTick> ticks{
      {0, tick_text(-most, step)}, {0.5, "0"}, {1, tick_text(most, step)}};
  return bar(colours, ticks, unit, [](int /*x*/, int /*y*/) { return error_colour(std::nan("")); });
}

std::string finding_legend(const std::vector<KeyEntry>& entries) {
  std::string html = "<div class=\"key\">";
  for (const KeyEntry& entry : entries) {
    html += swatch(entry.finding == Finding::kMissing
                       ? "repeating-conic-gradient(" + css_colour(none_colour(0, 0)) + " 0 25%," +
                             css_colour(none_colour(3, 0)) + " 0 50%) 0 0/6px 6px"
                       : css_colour(finding_colour(entry.finding)),
                   entry.meaning);
  }
  return html + "</div>";
}

std::string difference_legend() {
  return finding_legend({{Finding::kRight, "right"},
                         {Finding::kTooNear, "too near"},
                         {Finding::kTooFar, "too far"},
                         {Finding::kMissing, "none"},
                         {Finding::kUnknown, "no truth"}});
}

std::string removal_legend() {
  return finding_legend({{Finding::kRight, "kept"},
                         {Finding::kRightlyRemoved, "removed, was wrong"},
                         {Finding::kWronglyRemoved, "removed, was right"},
                         {Finding::kMissing, "none before"},
                         {Finding::kUnknown, "removed, no truth"}});
}

std::string colour_legend(const std::vector<std::pair<Rgb, std::string>>& entries) {
  std::string html = "<div class=\"key\">";
  for (const auto& [colour, meaning] : entries) {
    html += swatch(css_colour(colour), meaning);
  }
  return html + "</div>";
}

}  // namespace stof::host

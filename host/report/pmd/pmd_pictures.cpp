#include "host/report/pmd/pmd_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include "host/evaluate/stereo/median.h"
#include "host/picture/disparity_picture.h"
#include "host/picture/error_picture.h"
#include "host/picture/height_field.h"
#include "host/report/page/legend.h"
#include "host/report/page/plot.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// Black is 0, white is `most`.
dataset::Image<std::uint8_t> grey_map(const dataset::Image<float>& values, double most) {
  constexpr double kWhite = 255;
  dataset::Image<std::uint8_t> grey(values.width, values.height);
  std::ranges::transform(values.pixels, grey.pixels.begin(), [most](float value) {
    return static_cast<std::uint8_t>(kWhite * std::clamp(value / most, 0.0, 1.0));
  });
  return grey;
}

dataset::Image<float> off_by_mm(const dataset::Image<float>& z_m, double true_m) {
  dataset::Image<float> out(z_m.width, z_m.height);
  std::ranges::transform(z_m.pixels, out.pixels.begin(),
                         [true_m](float z) { return static_cast<float>((z - true_m) * kMm); });
  return out;
}

Figure signed_figure(const dataset::Image<float>& values, const char* unit, std::string title,
                     std::string caption) {
  const double most = largest_error(values);
  return figure(error_picture(values, most), std::move(title), std::move(caption),
                error_legend(most, unit));
}

PlotSeries across(const WallView& view, const char* name, Rgb colour) {
  PlotSeries series{.name = name, .colour = colour};
  const int y = view.z_m.height / 2;
  for (int x = 0; x < view.z_m.width; ++x) {
    series.add(x, view.z_m.view().at(x, y));
  }
  return series;
}

// The 2.5D view of a map of Z, +inf or NaN = none. Closeness in px of a disparity, so that planes
// stay planes; what is near has near_px. Noise of 2 px would tear the surface.
dataset::Image<Rgb> height_field_of(const dataset::Image<float>& z_m,
                                    const dataset::Image<std::uint8_t>& texture, double near_px) {
  std::vector<double> seen;
  std::ranges::copy_if(z_m.pixels, std::back_inserter(seen),
                       [](float z) { return std::isfinite(z) && z > 0; });
  constexpr double kTails = 0.01;
  const double near_m = percentile(seen, kTails).value_or(1);
  const double far_m = percentile(seen, 1 - kTails).value_or(2);
  dataset::Image<float> closeness(z_m.width, z_m.height, kNoDisparity);
  for (std::size_t i = 0; i < z_m.pixels.size(); ++i) {
    if (std::isfinite(z_m.pixels[i]) && z_m.pixels[i] > 0) {
      closeness.pixels[i] = static_cast<float>(near_px * near_m / z_m.pixels[i]);
    }
  }
  const double far_px = std::min(near_px * near_m / far_m, near_px - 1);
  return height_field_picture(closeness, closeness, far_px, near_px, texture);
}

}  // namespace

std::vector<Figure> mask_figures(const WallStudy& study) {
  // The farthest wall that has a reading at all.
  for (const WallRow& row : std::views::reverse(study.report.rows)) {
    const WallView& view = row.view;
    if (view.valid == 0) {
      continue;
    }
    const std::string at = number(row.z_m, 2) + " m";
    const double most = std::max<double>(std::ranges::max(view.modulation.pixels), 1e-6);
    return {figure(grey_map(view.modulation, most), "Modulation ratio, wall at " + at,
                   "Mean over the frames of each pixel: black is 0, white " + number(most, 2) +
                       "; the limit is " +
                       number(study.calibration.sensor.frequency.min_modulation_ratio, 2) + "."),
            figure(grey_map(view.valid_share, 1), "Valid pixels, wall at " + at,
                   "In how many of the frames a pixel carries a distance: black none, white "
                   "all.")};
  }
  return {};
}

std::vector<Figure> flat_wall_figures(const WallStudy& study) {
  if (study.plain.z_m.pixels.empty()) {
    return {};
  }
  const std::string at = number(study.shown_m, 2) + " m";
  PlotSeries wall{.name = "wall", .colour = kPlotGrey};
  wall.add(0, study.shown_m);
  wall.add(study.full.z_m.width - 1, study.shown_m);
  const Plot section{.title = "Across the middle row, wall at " + at,
                     .x_label = "column, px",
                     .y_label = "mean Z over the frames, m",
                     .series = {wall, across(study.plain, "no calibration", kPlotOrange),
                                across(study.full, "calibrated", kPlotBlue)}};
  const std::string values = "Z of the readings less Z of the wall. ";
  return {
      signed_figure(off_by_mm(study.plain.z_m, study.shown_m), "mm",
                    "A flat wall at " + at + ", no calibration",
                    values + "Mean over the frames: offset, wiggling, fixed pattern and the place "
                             "of the lights bend it."),
      signed_figure(off_by_mm(study.full.z_m, study.shown_m), "mm", "The same, calibrated",
                    values + "What is left is noise. The scale is another one."),
      plot_figure(section, "Both, and the wall.")};
}

std::vector<Figure> pattern_figures(const PmdCalibration& calibration) {
  const PmdModel& model = calibration.model;
  if (model.pattern.empty()) {
    return {};
  }
  dataset::Image<float> map(calibration.data.lens.width, calibration.data.lens.height);
  std::ranges::transform(model.pattern, map.pixels.begin(), [&model](double turns) {
    return static_cast<float>(turns * model.turn_m * kMm);
  });
  return {signed_figure(map, "mm", "Fixed pattern of the distance",
                        "What each pixel reads too much, whatever the distance.")};
}

Figure marks_figure(const EdgeStudy& study) {
  constexpr Rgb kMissed{213, 94, 0};
  constexpr Rgb kFound{0, 158, 115};
  constexpr Rgb kBeside{86, 180, 233};
  constexpr Rgb kEmpty{20, 20, 20};
  constexpr unsigned kMixed = 1;
  constexpr unsigned kFlagged = 2;
  constexpr unsigned kWithout = 4;
  dataset::Image<Rgb> picture(study.marks.width, study.marks.height);
  for (std::size_t i = 0; i < study.marks.pixels.size(); ++i) {
    const unsigned marks = study.marks.pixels[i];
    const std::uint8_t grey = study.amplitude.pixels[i];
    Rgb colour{grey, grey, grey};
    if ((marks & kWithout) != 0) {
      colour = kEmpty;
    } else if ((marks & kMixed) != 0) {
      colour = (marks & kFlagged) != 0 ? kFound : kMissed;
    } else if ((marks & kFlagged) != 0) {
      colour = kBeside;
    }
    picture.pixels[i] = colour;
  }
  return figure(picture, "Mixed and flagged pixels of " + study.section.name,
                "First frame, over its amplitude. A pixel is mixed when two surfaces meet in it; "
                "the flag says that its neighbourhood differs by more than noise.",
                colour_legend({{kFound, "mixed, flagged"},
                               {kMissed, "mixed, not flagged"},
                               {kBeside, "pure, flagged"},
                               {kEmpty, "no depth"}}));
}

Figure height_field_figure(const EdgeStudy& study) {
  constexpr double kNoisyPx = 20;
  return figure(height_field_of(study.z_m, study.amplitude, kNoisyPx),
                "2.5D view of " + study.section.name,
                "Z of one frame as a height field, near is high, lit by the amplitude of its own "
                "light. Holes are pixels without a distance.");
}

std::vector<Figure> cloud_figures(const FrameStudy& study) {
  constexpr double kBright = 255;
  constexpr double kSharpPx = 60;
  dataset::Image<std::uint8_t> texture(study.width, study.height, 255);
  if (std::ranges::any_of(study.amplitude.pixels, [](float a) { return a > 0; })) {
    std::vector<double> all(study.amplitude.pixels.begin(), study.amplitude.pixels.end());
    constexpr double kMostBright = 0.98;
    const double most = percentile(std::move(all), kMostBright).value_or(1);
    std::ranges::transform(study.amplitude.pixels, texture.pixels.begin(), [most](float a) {
      return static_cast<std::uint8_t>(kBright * std::min(std::sqrt(a / most), 1.0));
    });
  }
  return {
      figure(texture, "Amplitude", "Of the camera's frame, its root."),
      figure(height_field_of(study.cloud.z, texture, kSharpPx), "2.5D view of the cloud",
             "Z of the appliance's cloud as a height field, near is high. Holes are pixels that "
             "the camera calls invalid.")};
}

}  // namespace stof::host

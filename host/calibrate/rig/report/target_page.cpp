#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/calibrate/rig/report/rig_report.h"
#include "host/report/page/plot.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// By how much residuals are shown larger than the picture's pixels: the first step at which
// one of `sigma_px` is 10 of the picture's pixels long.
double magnified(double sigma_px) {
  constexpr std::array<double, 7> kSteps{50, 100, 200, 500, 1000, 2000, 5000};
  constexpr double kShownPx = 10;
  const auto* const enough =
      std::ranges::find_if(kSteps, [sigma_px](double step) { return step * sigma_px >= kShownPx; });
  return enough == kSteps.end() ? kSteps.back() : *enough;
}

// The corners of the picture, so that all diagrams show the same.
PlotSeries frame_of(const dsp::Pinhole& lens) {
  PlotSeries frame{.name = "", .colour = kPlotGrey};
  for (const auto& [x, y] :
       {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1), std::pair(0, 0)}) {
    frame.add(x * (lens.width - 1.0), y * (lens.height - 1.0));
  }
  return frame;
}

// Where corners were found, and lines to where the calibration puts them.
Figure residual_figure(const std::string& name, const char* eye,
                       const std::vector<PixelPoint>& corners,
                       const std::vector<PixelPoint>& residuals, const dsp::Pinhole& lens,
                       double times) {
  PlotSeries found{.name = "corner", .colour = kPlotBlue, .line = false, .dot_px = 3};
  PlotSeries off{.name = printed("off, times %.0f", times), .colour = kPlotOrange};
  double squares = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!corners[i].seen()) {
      continue;
    }
    // Rows grow downwards in a picture, upwards in a diagram.
    const double y = lens.height - 1 - corners[i].v;
    found.add(corners[i].u, y);
    off.add(corners[i].u, y);
    off.add(corners[i].u + times * residuals[i].u, y - times * residuals[i].v);
    off.add(std::numeric_limits<double>::quiet_NaN(), y);
    squares += residuals[i].u * residuals[i].u + residuals[i].v * residuals[i].v;
  }
  const double rms = std::sqrt(squares / static_cast<double>(2 * seen_corners(corners)));
  return plot_figure({.title = name + ", " + eye,
                      .x_label = "column, px",
                      .y_label = "row from below, px",
                      .series = {frame_of(lens), found, off},
                      .y_least = 0,
                      .y_most = lens.height - 1.0},
                     printed("%.3f px rms of a coordinate", rms));
}

void add_views(const std::vector<PairView>& views, const std::vector<ViewResiduals>& residuals,
               const PairFit& fit, Page& page) {
  const double times = magnified(fit.corner_sigma_px);
  std::vector<Figure> figures;
  for (std::size_t n = 0; n < std::min(views.size(), residuals.size()); ++n) {
    if (!views[n].left.empty()) {
      figures.push_back(residual_figure(views[n].name, "left", views[n].left, residuals[n].left,
                                        fit.rig.left, times));
    }
    if (!views[n].right.empty()) {
      figures.push_back(residual_figure(views[n].name, "right", views[n].right, residuals[n].right,
                                        fit.rig.right, times));
    }
  }
  page.figures(figures, Width::kSmall);
}

Figure all_corners(const char* eye, const std::vector<PairView>& views,
                   std::vector<PixelPoint> PairView::* of_eye, const dsp::Pinhole& lens) {
  PlotSeries corners{.name = "", .colour = kPlotBlue, .line = false, .dot_px = 2};
  for (const PairView& view : views) {
    for (const PixelPoint& corner : view.*of_eye) {
      if (!corner.seen()) {
        continue;
      }
      corners.add(corner.u, lens.height - 1 - corner.v);
    }
  }
  return plot_figure({.title = std::string("All corners, ") + eye,
                      .x_label = "column, px",
                      .y_label = "row from below, px",
                      .series = {frame_of(lens), corners},
                      .y_least = 0,
                      .y_most = lens.height - 1.0},
                     "Where no corner is, distortion is extrapolated.");
}

Table view_table(const TargetCalibration& found) {
  Table table{.caption = "Views that were fitted to",
              .header = {"view", "off, px", "distance, m", "of the picture, %", "turned, degrees",
                         "tilted, degrees"}};
  for (std::size_t n = 0; n < found.fitted.size(); ++n) {
    const ViewPose& pose = found.poses[n];
    table.rows.push_back({found.fitted[n].name, number(found.fit.residuals[n].rms_px, 3),
                          number(pose.distance_m, 2), percent(pose.share),
                          number(pose.sideways_rad * kDegrees, 0),
                          number(pose.upwards_rad * kDegrees, 0)});
  }
  return table;
}

Table missing_table(const TargetCalibration& found) {
  Table table{.caption = "Views that are missing, and views that do not count",
              .header = {"what", "why"},
              .text_columns = 2};
  for (const std::string& line : found.missing) {
    table.rows.push_back({"missing", line});
  }
  for (const RefusedView& view : found.refused) {
    table.rows.push_back({view.name, view.why});
  }
  return table;
}

}  // namespace

std::expected<void, dataset::Problem> write_target_page(const TargetCalibration& found,
                                                        const std::filesystem::path& file) {
  Page page;
  page.begin_section("views", "Views");
  page.table(missing_table(found));
  page.table(view_table(found));
  page.figures({all_corners("left", found.fitted, &PairView::left, found.fit.rig.left),
                all_corners("right", found.fitted, &PairView::right, found.fit.rig.right)},
               Width::kMedium);
  page.begin_section("held", "Residuals of views that were held out");
  add_views(found.held_out, found.held_residuals, found.fit, page);
  page.begin_section("fitted", "Residuals of views that were fitted to");
  add_views(found.fitted, found.fit.residuals, found.fit, page);
  std::vector<std::string> lead{
      printed("%zu views of a board; corners are off by %.3f px of a coordinate.",
              found.fitted.size(), found.fit.corner_sigma_px)};
  if (found.judgement) {
    lead.push_back(
        printed("%zu views that were held out: %.3f px, rows of the rectified pictures "
                "%.3f px rms.",
                found.judgement->views, found.judgement->reprojection_px, found.judgement->row_px));
  }
  return write_page(file, page.html("A pair of cameras, calibrated", lead));
}

}  // namespace stof::host

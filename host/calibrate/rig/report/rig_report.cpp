#include "host/calibrate/rig/report/rig_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/text/printed.h"

namespace stof::host {
namespace {

// What a good rig stays below: docs/CALIBRATION.md, step 5.
constexpr double kGoodRowPx = 0.3;
constexpr double kGoodScale = 0.005;
constexpr double kGoodCornerPx = 0.2;

std::string lens_row(const char* name, const PairFit& fit, std::size_t i) {
  const LensUnknowns left = unknowns_of(fit.rig.left);
  const LensUnknowns right = unknowns_of(fit.rig.right);
  return printed("  %-4s %12.5f +- %-10.5f %12.5f +- %-10.5f\n", name, left[i], fit.sigma(i),
                 right[i], fit.sigma(kLensUnknowns + i));
}

std::string pose_rows(const PoseUnknowns& pose, const std::array<double, kPoseUnknowns>& sigma,
                      const char* what) {
  constexpr std::array kAxes{"x", "y", "z"};
  std::string text;
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    text += printed("  %s turn %s %9.4f +- %.4f degrees    shift %s %9.2f +- %.2f mm\n", what,
                    kAxes[i], pose[i] * kDegrees, sigma[i] * kDegrees, kAxes[i], pose[3 + i] * kMm,
                    sigma[3 + i] * kMm);
  }
  return text;
}

std::string place_rows(const ExtrinsicFit& fit) {
  std::array<double, kPoseUnknowns> sigma{};
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    sigma[i] = std::sqrt(fit.covariance(k, k));
  }
  return pose_rows(fit.pmd_to_stereo, sigma, "PMD");
}

std::string judgement_text(const TargetJudgement& judgement) {
  return printed(
      "held out: %zu views: reprojection %.3f px rms, rows %.3f px rms (largest %.2f), "
      "squares %+.2f percent\n",
      judgement.views, judgement.reprojection_px, judgement.row_px, judgement.largest_row_px,
      judgement.scale_error * kPercent);
}

// From the disparities, or what was told.
std::string source_of(double sigma, double prior) {
  if (!std::isfinite(prior)) {
    return "";
  }
  constexpr double kPriorAlone = 0.9;
  return sigma > kPriorAlone * prior ? " (what was told; the pictures add nothing)"
                                     : printed(" (told to %.4g)", prior);
}

std::string chapter_text(const PlaneCalibration::Chapter& chapter) {
  return printed(
      "chapter's objective, one mean disparity a wall (rms of Z, mm):\n"
      "  its genes %.1f in %.1f s; the same at the absolute columns %.1f\n"
      "  Table 2: %.1f at the principal column, %.1f at best, %+.0f px from it; "
      "b F cos^2(alpha) %.4g m^2, axes meet at %.2f m\n"
      "  refined constants %.1f\n",
      chapter.genes.rms_m * kMm, chapter.genes.seconds, chapter.elsewhere_rms_m * kMm,
      chapter.table2_rms_m * kMm, chapter.table2_best_rms_m * kMm, chapter.best_offset_px,
      triangulation_constant(kTable2), zero_disparity_m(kTable2), chapter.refined_rms_m * kMm);
}

}  // namespace

std::vector<std::string> notes_of(const TargetCalibration& found) {
  std::vector<std::string> notes;
  const double off =
      std::max(found.fit.corner_sigma_px, found.judgement ? found.judgement->reprojection_px : 0.0);
  if (off > kGoodCornerPx) {
    notes.push_back(
        printed("corners are off by %.2f px, and good is %.1f or less: the board is not flat, or "
                "--board is another one, such as of another gap",
                off, kGoodCornerPx));
  }
  if (found.judgement && found.judgement->row_px > kGoodRowPx) {
    notes.push_back(
        printed("rows of both pictures are apart by %.2f px, and good is %.1f or "
                "less: take more views, tilted ones above all",
                found.judgement->row_px, kGoodRowPx));
  }
  if (found.judgement && std::abs(found.judgement->scale_error) > kGoodScale) {
    notes.push_back(
        printed("squares come out %.2f percent too %s, and good is %.1f or less: measure the "
                "board along ten squares",
                std::abs(found.judgement->scale_error) * kPercent,
                found.judgement->scale_error > 0 ? "large" : "small", kGoodScale * kPercent));
  }
  notes.insert(notes.end(), found.notes.begin(), found.notes.end());
  return notes;
}

std::string target_text(const TargetCalibration& found) {
  const PairFit& fit = found.fit;
  std::string text = printed(
      "%zu views fitted, corners off by %.3f px (one coordinate)\n"
      "         left                          right\n",
      found.fitted.size(), fit.corner_sigma_px);
  for (std::size_t i = 0; i < kLensUnknowns; ++i) {
    const bool fitted = (i != 8 || found.k3) && ((i != 6 && i != 7) || found.tangential);
    text += fitted ? lens_row(kLensNames[i], fit, i)
                   : printed("  %-4s 0: the views do not ask for it\n", kLensNames[i]);
  }
  std::array<double, kPoseUnknowns> sigma{};
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    sigma[i] = fit.sigma(2 * kLensUnknowns + i);
  }
  text += pose_rows(pose_of(fit.rig.left_to_right), sigma, "right");
  text += found.judgement ? judgement_text(*found.judgement)
                          : std::string("held out: none; nothing judges this calibration\n");
  for (const RefusedView& view : found.refused) {
    text += "left out: " + view.name + ": " + view.why + "\n";
  }
  for (const std::string& line : found.missing) {
    text += "missing: " + line + "\n";
  }
  for (const std::string& line : notes_of(found)) {
    text += "note: " + line + "\n";
  }
  return text;
}

std::string planes_text(const PlaneCalibration& found) {
  const PlaneFit& fit = found.fit;
  std::string text =
      printed("genes %.2f mm rms in %.1f s, refined %.2f mm\n", found.genes.rms_m * kMm,
              found.genes.seconds, found.refined_rms_m * kMm);
  for (std::size_t i = 0; i < kPlaneUnknowns; ++i) {
    text +=
        printed("  %-5s %11.7f +- %.7f %s%s\n", kPlaneNames[i], fit.x[i], fit.sigma(i),
                i == 1 || i == 2 ? "rad" : "m", source_of(fit.sigma(i), fit.from_prior[i]).c_str());
  }
  const double constant = triangulation_constant(fit.x);
  text += printed(
      "  b F cos^2(alpha) %.6g m^2 +- %.3f percent, alpha - beta %.6f rad +- %.6f, axes "
      "meet at %.3f m, cells %.3f px\n  covariance of",
      constant, fit.constant_sigma / constant * kPercent, fit.x[1] - fit.x[2], fit.difference_sigma,
      zero_disparity_m(fit.x), fit.cell_sigma_px);
  for (const char* const name : kPlaneNames) {
    text += printed(" %s", name);
  }
  text += "\n";
  for (Eigen::Index i = 0; i < fit.covariance.rows(); ++i) {
    text += "   ";
    for (Eigen::Index k = 0; k < fit.covariance.cols(); ++k) {
      text += printed(" %11.3e", fit.covariance(i, k));
    }
    text += "\n";
  }
  text += "   z, m  spread, mm  bias, mm  depths  left out, %\n";
  for (const WallJudgement& wall : found.walls) {
    text += printed("  %5.3f %11.1f %9.1f %7.0f %9.1f%s\n", wall.z_m, wall.spread_m * kMm,
                    wall.bias_m * kMm, wall.pixels, wall.dropped * kPercent,
                    wall.fitted ? "" : "  held out");
  }
  const double held_out = pooled_spread_m(found.walls, false) * kMm;
  text += printed("spread over the fitted walls %.1f mm, held out %s\n",
                  pooled_spread_m(found.walls, true) * kMm,
                  std::isfinite(held_out) ? printed("%.1f mm", held_out).c_str()
                                          : "none; nothing judges these constants");
  return found.chapter ? text + chapter_text(*found.chapter) : text;
}

std::string extrinsics_text(const ExtrinsicFit& fit, const FoundWalls& found) {
  std::string text = printed(
      "%zu walls, misfit %.2f (1: as the readings scatter), the sensors see them %.2f degrees and "
      "%.1f mm apart\n",
      found.walls.size(), fit.misfit, fit.turned_rad * kDegrees, fit.apart_m * kMm);
  text += place_rows(fit);
  text += printed("  PMD distances are off by %+.1f +- %.1f mm (+: read too far)\n",
                  fit.offset_m * kMm, fit.offset_sigma_m * kMm);
  text += "  wall              off, sigmas  on the plane, %: pair, PMD\n";
  for (std::size_t n = 0; n < found.walls.size(); ++n) {
    const SeenWall& wall = found.walls[n];
    text += printed("  %-17s %11.1f %13.0f %5.0f\n", wall.name.c_str(), fit.wall_misfit[n],
                    wall.stereo.share * kPercent, wall.pmd.share * kPercent);
  }
  return text;
}

std::string board_extrinsics_text(const ExtrinsicFit& fit, const PmdBoardViews& found) {
  std::string text =
      printed("%zu views of the board, misfit %.2f (1: views agree as corners scatter)\n",
              found.views.size(), fit.misfit) +
      place_rows(fit);
  text += "  view              off, sigmas\n";
  for (std::size_t n = 0; n < found.views.size(); ++n) {
    text += printed("  %-17s %11.1f\n", found.views[n].pair.name.c_str(), fit.wall_misfit[n]);
  }
  return text;
}

std::string check_text(const RigCheck& check) {
  std::string text;
  if (check.rows) {
    text += printed(
        "rows: %zu points: median %+.2f px, rms %.2f px, %+.2f px from the left border "
        "to the right\n",
        check.rows->points, check.rows->median_px, check.rows->rms_px, check.rows->slope_px);
  } else {
    text += "rows: too few points that both eyes see\n";
  }
  if (check.depths) {
    text += printed(
        "depth: %zu readings: the PMD camera reads %+.0f mm farther at 2 m, spread %.0f "
        "mm\n",
        check.depths->points, check.depths->median_mm, check.depths->spread_mm);
  } else {
    text +=
        "depth: no PMD recordings (pmd.json, pmd_raw.pgm) beside the pictures, or too few "
        "readings that the pair sees\n";
  }
  const std::vector<std::string> lines = advice(check);
  for (const std::string& line : lines) {
    text += "do: " + line + "\n";
  }
  for (const std::string& line : doubts(check)) {
    text += "not judged: " + line + "\n";
  }
  return lines.empty() ? text + "nothing to do\n" : text;
}

}  // namespace stof::host

#include "host/evaluate/pmd/print/text.h"

#include <cmath>

#include "host/evaluate/stereo/median.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kShown = 0.005;  // shares below are 0 percent

std::string percent_cell(long part, long whole, int width) {
  return cell(
      whole == 0 ? std::nan("") : kPercent * static_cast<double>(part) / static_cast<double>(whole),
      width, 2);
}

void add_stray(const WallStudy& study, std::string& text) {
  if (study.stray.empty()) {
    return;
  }
  text += printed(
      "\nstray light: I %.1f, Q %.1f LSB (+- %.1f), as of a surface at %.2f m; mean Z of the "
      "middle less the wall's\nbefore: the recording's own constants; after: the same with this "
      "phasor\n\n",
      study.stray_i_lsb, study.stray_q_lsb, study.stray_sigma_lsb, study.stray_apparent_m);
  text += printed("%7s  %10s %7s  %10s %7s  %s\n", "z, m", "before, mm", "valid", "after, mm",
                  "valid", "flagged before, % of the middle");
  for (const StrayRow& row : study.stray) {
    std::string flags;
    for (std::size_t bit = 0; bit < kPmdFlags; ++bit) {
      if (row.before.flagged[bit] >= kShown) {
        add_to(flags,
               printed("%s %.0f", pmd_flag_names()[bit], kPercent * row.before.flagged[bit]));
      }
    }
    text += printed(
        "%7.3f  %s %s  %s %s  %s\n", row.z_m, cell(row.before.error_m * kMm, 10, 1).c_str(),
        cell(row.before.valid * kPercent, 7, 0).c_str(),
        cell(row.after.error_m * kMm, 10, 1).c_str(),
        cell(row.after.valid * kPercent, 7, 0).c_str(), flags.empty() ? "nothing" : flags.c_str());
  }
}

void add_lights(const LightStudy& study, std::string& text) {
  text += printed(
      "%s: a wall lit from beside the lens; mean over pixels, and over blocks of 8x8, of |mean "
      "radial error|, mm\n\n",
      study.folder.c_str());
  text += printed("%7s  %17s  %17s\n", "", "lights at the lens", "near model");
  text += printed("%7s  %8s %8s  %8s %8s  %6s\n", "z, m", "pixels", "blocks", "pixels", "blocks",
                  "pixels");
  for (const LightRow& row : study.rows) {
    text +=
        printed("%7.3f  %8.2f %8.2f  %8.2f %8.2f  %6d\n", row.z_m, row.before_m * kMm,
                row.before_blocks_m * kMm, row.after_m * kMm, row.after_blocks_m * kMm, row.pixels);
  }
}

void add_counts(const std::string& name, const EdgeCounts& c, std::string& text) {
  const long beyond = c.pure_with_depth - c.pure_beside;
  text += printed(
      "%-18s %7ld %7ld %s %s  %7ld %s %s %s  %s %s\n", name.c_str(), c.mixed, c.mixed_with_depth,
      percent_cell(c.mixed_flagged, c.mixed_with_depth, 8).c_str(),
      percent_cell(c.holding, c.mixed_with_depth, 8).c_str(), c.pure_with_depth,
      percent_cell(c.pure_flagged, c.pure_with_depth, 8).c_str(),
      percent_cell(c.pure_flagged_beside, c.pure_beside, 8).c_str(),
      percent_cell(c.pure_flagged - c.pure_flagged_beside, beyond, 8).c_str(),
      c.pure_error_m.empty() ? "       -" : cell(*median(c.pure_error_m) * kMm, 8, 1).c_str(),
      c.pure_error_m.empty() ? "       -"
                             : percent_cell(c.pure_holding, c.pure_with_depth, 8).c_str());
}

void add_edges(const EdgeStudy& study, const char* what, std::string& text) {
  text += printed(
      "%s: %s\nmixed pixels see two surfaces (r_max - r_min above the surface's slope). Shares, "
      "%%, of those with a depth;\nholds: [low, high] holds both surfaces, or the middle one of a "
      "pure pixel\n\n",
      study.folder.c_str(), what);
  text += printed("%-18s %7s %7s %8s %8s  %7s %8s %8s %8s  %8s %8s\n", "", "mixed", "depth",
                  "flagged", "holds", "pure", "flagged", "beside", "beyond", "error,mm", "holds");
  for (const EdgeRow& row : study.rows) {
    add_counts(row.name, row.counts, text);
  }
  add_counts("all", study.all, text);
}

void add_frequencies(const FrequencyStudy& study, std::string& text) {
  text += printed("%s: two modulation frequencies\n\n", study.folder.c_str());
  text += printed("%16s  %9s  %15s  %7s  %8s  %7s  %6s  %10s\n", "MHz", "period, m", "wall, m",
                  "ratio", "accepted", "%", "wrong", "median, mm");
  for (const FrequencyRow& row : study.rows) {
    text += printed("%7.5g + %6.5g  %9.2f  %6.2f .. %5.2f  %7.2f  %8ld  %s  %6ld  %s\n",
                    row.first_mhz, row.second_mhz, row.period_m, row.nearest_m, row.farthest_m,
                    row.min_ratio, row.accepted, percent_cell(row.accepted, row.pixels, 7).c_str(),
                    row.wrong, cell(row.median_error_m * kMm, 10, 1).c_str());
  }
}

void add_frame(const FrameStudy& frame, std::string& text) {
  text += printed("%s: a frame of an ifm camera, %dx%d, %ld pixels with a distance\n\n",
                  frame.folder.c_str(), frame.width, frame.height, frame.valid);
  if (!frame.buffer) {
    text += "absent: O3RBuffer.data\n";
  } else {
    text += printed("distances       %s those of the camera's buffer\n",
                    frame.same_distances ? "are" : "differ from");
  }
  if (frame.camera) {
    text += printed("cloud           off the camera's own by %.3f mm at most, median %.3f mm\n",
                    frame.camera->largest_m * kMm, frame.camera->median_m * kMm);
  } else {
    text += "absent: Cartesian images (chunks 200 to 202) in the camera's buffer\n";
  }
  text += printed(
      "cloud           in fixed point, off the same in double precision by %.3f mm at most, median "
      "%.3f mm\n",
      frame.exact.largest_m * kMm, frame.exact.median_m * kMm);
  if (frame.way_back) {
    text += printed(
        "rays            off the camera's own polynomial of the way back by %.2f mm at most, "
        "median "
        "%.2f mm\n",
        frame.way_back->largest_m * kMm, frame.way_back->median_m * kMm);
  }
  text += printed(
      "noise           rank correlation of 1 / amplitude with the camera's noise %s%s (median "
      "noise "
      "%s mm)\n",
      cell(frame.rank_correlation, 1, 3).c_str(),
      frame.knows_exposures ? ", exposure for exposure" : "",
      cell(frame.median_noise_m * kMm, 1, 2).c_str());
  if (frame.knows_exposures) {
    text += printed(
        "                %s with the amplitude image as it is, which is scaled to one exposure\n",
        cell(frame.rank_correlation_as_given, 1, 3).c_str());
  }
}

}  // namespace

std::string pmd_text(const PmdEvaluation& evaluation) {
  std::string text;
  text += printed(
      "phase           of %ld random samples off by %.4f LSB at most (mean %.4f); kernels ref and "
      "neon equal: %s\n",
      evaluation.phase.pixels, evaluation.phase.largest_lsb, evaluation.phase.mean_lsb,
      evaluation.phase.kernels_equal ? "yes" : "no");
  for (const WallStudy& study : evaluation.walls) {
    text += "\n" + report_text(study.report, study.calibration);
    if (study.given) {
      text +=
          "given           \"calibrated\" is by the calibration file; the constants above are what "
          "these walls ask for\n";
    }
    add_stray(study, text);
  }
  for (const LightStudy& study : evaluation.lights) {
    text += "\n";
    add_lights(study, text);
  }
  for (const EdgeStudy& study : evaluation.edges) {
    text += "\n";
    add_edges(study, "the edge of a board before a wall", text);
  }
  for (const FrequencyStudy& study : evaluation.frequencies) {
    text += "\n";
    add_frequencies(study, text);
  }
  for (const EdgeStudy& study : evaluation.scenes) {
    text += "\n";
    add_edges(study, "scenes", text);
  }
  for (const FrameStudy& frame : evaluation.frames) {
    text += "\n";
    add_frame(frame, text);
  }
  text += evaluation.notes.empty() ? "" : "\n";
  for (const std::string& note : evaluation.notes) {
    text += note + "\n";
  }
  return text;
}

}  // namespace stof::host

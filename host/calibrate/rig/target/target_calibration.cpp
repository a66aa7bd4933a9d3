#include "host/calibrate/rig/target/target_calibration.h"

#include <algorithm>
#include <cmath>

#include "dataset/files/file.h"
#include "dsp/base/index.h"
#include "dsp/base/random.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/calib/stereo/rectification.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/calibrate/rig/target/pair_start.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// A view that fits this much worse than most has wrong corners, or the board bent or moved.
constexpr double kOutlierRatio = 3;
constexpr double kLeastOutlierPx = 0.3;
constexpr int kMostOutliers = 3;
// By how much further coefficients of both lenses have to lower the sum of squares, in variances of
// a coordinate: chance alone makes one of each coefficient. Those that lenses do not have cost the
// other constants certainty.
constexpr double kExplains = 20;
// A focal length that is less certain than this comes from views that are too much alike.
constexpr double kLargestFocalSigma = 0.005;
constexpr double kMostCornerPx = 1;  // of a calibration that is one
constexpr double kSameBaselineShare = 0.005;
constexpr double kMostBaselineShare = 0.05;  // that a rig's baseline differs from what was known
constexpr std::size_t kMirrorLooks = 3;      // pictures that are looked at

using dsp::index;
using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Matrix3 matrix_of(const std::array<double, 9>& elements) {
  return Eigen::Map<const RowMatrix>(elements.data());
}

// An eye's corners, or none where it does not see the board whole, or why the view does not count.
std::vector<PixelPoint> corners_of(const dataset::Image<std::uint8_t>& picture, const char* eye,
                                   const TargetOptions& options, std::size_t& seen,
                                   std::string& why) {
  std::optional<FoundBoard> found = find_board(picture, options.board);
  if (!found) {
    return {};
  }
  ++seen;
  if (!(found->blur_px <= options.most_blur_px)) {
    why =
        std::isfinite(found->blur_px)
            ? printed("blurred: edges of the %s picture are smoothed by %.1f px, %.1f are allowed",
                      eye, found->blur_px, options.most_blur_px)
            : printed("the %s picture is too dark", eye);
    return {};
  }
  return std::move(found->corners);
}

// Whether an eye that never sees the board does where its pictures are mirrored. A chessboard looks
// the same in a mirror.
bool mirrored(const std::vector<std::filesystem::path>& pairs, const Board& board, bool right) {
  if (!board.has_markers()) {
    return false;
  }
  for (std::size_t n = 0; n < std::min(pairs.size(), kMirrorLooks); ++n) {
    dataset::Loaded<Pair> pair = read_pair(pairs[n * pairs.size() / kMirrorLooks]);
    if (!pair) {
      return false;
    }
    dataset::Image<std::uint8_t>& picture = right ? pair->right : pair->left;
    for (int v = 0; v < picture.height; ++v) {
      std::ranges::reverse(picture.view().row(v));
    }
    if (find_board_roughly(picture, board)) {
      return true;
    }
  }
  return false;
}

struct Split {
  std::vector<PairView> fitted;
  std::vector<PairView> held_out;
};

// Which views judge: drawn by lot, because views are taken in some order, and those alone without
// which the others reach as much of the pictures.
Split split(std::vector<PairView> views, int hold_out, int width, int height) {
  const auto both = static_cast<std::size_t>(std::ranges::count_if(views, &PairView::both));
  std::size_t wanted = hold_out > 1 ? both / static_cast<std::size_t>(hold_out) : 0;
  const unsigned all = reached_corners(views, width, height);
  Split parts{.fitted = std::move(views), .held_out = {}};
  dsp::SplitMix64 random(both);
  for (std::size_t tries = 8 * both; tries > 0 && wanted > 0; --tries) {
    const std::size_t n = random.next() % parts.fitted.size();
    if (!parts.fitted[n].both()) {
      continue;
    }
    std::vector<PairView> rest = parts.fitted;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(n));
    if (reached_corners(rest, width, height) == all) {
      parts.held_out.push_back(std::move(parts.fitted[n]));
      parts.fitted = std::move(rest);
      --wanted;
    }
  }
  return parts;
}

// The view that fits worst, where it fits much worse than most.
std::optional<std::size_t> outlier(const PairFit& fit) {
  std::vector<double> sorted;
  sorted.reserve(fit.residuals.size());
  for (const ViewResiduals& view : fit.residuals) {
    sorted.push_back(view.rms_px);
  }
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(sorted) - sorted.begin());
  const double most = sorted[worst];
  std::ranges::sort(sorted);
  const double middle = sorted[sorted.size() / 2];
  return most > kLeastOutlierPx && most > kOutlierRatio * middle ? std::optional(worst)
                                                                 : std::nullopt;
}

std::optional<PairFit> fit_without_outliers(const TargetOptions& options, PairStart start,
                                            const std::function<bool()>& stop,
                                            TargetCalibration& result) {
  std::optional<PairFit> fit;
  for (int round = 0; round <= kMostOutliers; ++round) {
    fit = fit_pair(options.board, result.fitted, start.rig, start.boards,
                   {.k3 = false, .tangential = false, .stop = stop});
    const std::optional<std::size_t> worst = fit ? outlier(*fit) : std::nullopt;
    if (!worst || round == kMostOutliers) {
      return fit;
    }
    const auto at = static_cast<std::ptrdiff_t>(*worst);
    result.refused.push_back(
        {result.fitted[*worst].name,
         printed("does not fit: corners are off by %.2f px, most views by less than a third of "
                 "that: did the board move or bend?",
                 fit->residuals[*worst].rms_px)});
    result.fitted.erase(result.fitted.begin() + at);
    start = {fit->rig, std::move(fit->boards)};
    start.boards.erase(start.boards.begin() + at);
  }
  return fit;
}

// Whether the views ask for further coefficients; then the fit is the one with them.
bool explains(const TargetOptions& options, const PairFitOptions& more, TargetCalibration& result) {
  std::optional<PairFit> fit =
      fit_pair(options.board, result.fitted, result.fit.rig, result.fit.boards, more);
  if (!fit ||
      !(result.fit.cost - fit->cost > kExplains * fit->corner_sigma_px * fit->corner_sigma_px)) {
    return false;
  }
  result.fit = std::move(*fit);
  return true;
}

struct Rectifier {
  explicit Rectifier(const dsp::RawPair& pair) : rig(pair), rectified(dsp::rectify(pair)) {}

  // Where a pixel of the left or right picture lies in the rectified one.
  PixelPoint left(const PixelPoint& p) const {
    return place(rig.left, rectified.left_turn, rectified.left, p);
  }
  PixelPoint right(const PixelPoint& p) const {
    return place(rig.right, rectified.right_turn, rectified.right, p);
  }
  Vector3 point(const PixelPoint& l, const PixelPoint& r) const {
    const double gap = (l.u - rectified.left.cx) - (r.u - rectified.right.cx);
    const double z = rectified.left.fx * rectified.baseline_m / gap;
    return {(l.u - rectified.left.cx) * z / rectified.left.fx,
            (l.v - rectified.left.cy) * z / rectified.left.fy, z};
  }

  dsp::RawPair rig;
  dsp::Rectification rectified;

 private:
  static PixelPoint place(const dsp::Pinhole& raw, const std::array<double, 9>& turn,
                          const dsp::Pinhole& to, const PixelPoint& p) {
    const std::array<double, 3> ray = dsp::unit_ray(raw, p.u, p.v);
    const Vector3 turned = matrix_of(turn) * Eigen::Map<const Vector3>(ray.data());
    return {to.fx * turned.x() / turned.z() + to.cx, to.fy * turned.y() / turned.z() + to.cy};
  }
};

// Both ends of each row against the board: the mean share that they are too far apart. Rows that
// are seen to less than half do not count.
double scale_error(const Board& board, const PairView& view, const Rectifier& rectifier) {
  double sum = 0;
  double rows = 0;
  for (int row = 0; row < board.rows; ++row) {
    std::vector<int> seen;
    for (int i = row * board.columns; i < (row + 1) * board.columns; ++i) {
      if (view.left[index(i)].seen() && view.right[index(i)].seen()) {
        seen.push_back(i);
      }
    }
    if (2 * seen.size() < index(board.columns)) {
      continue;
    }
    const auto place = [&](int i) {
      return rectifier.point(rectifier.left(view.left[index(i)]),
                             rectifier.right(view.right[index(i)]));
    };
    const double apart = board.at(seen.back())[0] - board.at(seen.front())[0];
    sum += (place(seen.back()) - place(seen.front())).norm() / apart - 1;
    rows += 1;
  }
  return rows > 0 ? sum / rows : 0;
}

std::optional<TargetJudgement> judge(const TargetOptions& options, TargetCalibration& result) {
  if (result.held_out.empty()) {
    return std::nullopt;
  }
  const Rectifier rectifier(result.fit.rig);
  TargetJudgement judgement;
  double squares = 0;
  double coordinates = 0;
  double rows = 0;
  double corners = 0;
  for (const PairView& view : result.held_out) {
    const std::optional<ViewResiduals> residuals = judge_view(options.board, view, result.fit.rig);
    if (!residuals) {
      continue;
    }
    result.held_residuals.push_back(*residuals);
    const auto count =
        static_cast<double>(2 * (seen_corners(view.left) + seen_corners(view.right)));
    squares += residuals->rms_px * residuals->rms_px * count;
    coordinates += count;
    for (const double row : row_errors(view, result.fit.rig)) {
      rows += row * row;
      corners += 1;
      judgement.largest_row_px = std::max(judgement.largest_row_px, std::abs(row));
    }
    judgement.scale_error += scale_error(options.board, view, rectifier);
    ++judgement.views;
  }
  if (judgement.views == 0) {
    return std::nullopt;
  }
  judgement.reprojection_px = std::sqrt(squares / coordinates);
  judgement.row_px = std::sqrt(rows / corners);
  judgement.scale_error /= static_cast<double>(judgement.views);
  return judgement;
}

// What to do where the focal lengths are uncertain.
std::optional<std::string> uncertain(const PairFit& fit) {
  const double left = fit.sigma(0) / fit.rig.left.fx;
  const double right = fit.sigma(kLensUnknowns) / fit.rig.right.fx;
  if (std::max(left, right) <= kLargestFocalSigma) {
    return std::nullopt;
  }
  return printed(
      "tilted: the focal length is uncertain by %.1f percent, %.1f is allowed: tilt the board "
      "more, "
      "and bring it nearer",
      std::max(left, right) * kPercent, kLargestFocalSigma * kPercent);
}

// Why nothing follows: where most views do not count, that.
std::unexpected<dataset::Problem> too_few(const TargetCalibration& result,
                                          const dataset::Problem& otherwise) {
  if (result.refused.size() <= result.fitted.size()) {
    return std::unexpected(otherwise);
  }
  const RefusedView& first = result.refused.front();
  return dataset::refuse(
      printed("%zu views of %zu do not count (%s: %s): take them anew", result.refused.size(),
              result.refused.size() + result.fitted.size() + result.held_out.size(),
              first.name.c_str(), first.why.c_str()));
}

}  // namespace

std::vector<double> row_errors(const PairView& view, const dsp::RawPair& rig) {
  const Rectifier rectifier(rig);
  std::vector<double> errors;
  for (std::size_t i = 0; i < std::min(view.left.size(), view.right.size()); ++i) {
    if (!view.left[i].seen() || !view.right[i].seen()) {
      continue;
    }
    errors.push_back(rectifier.left(view.left[i]).v - rectifier.right(view.right[i]).v);
  }
  return errors;
}

dataset::Loaded<TargetViews> find_views(const std::filesystem::path& folder,
                                        const TargetOptions& options,
                                        const std::function<bool()>& stop) {
  const dataset::Loaded<std::vector<std::filesystem::path>> pairs = list_pairs(folder);
  if (!pairs) {
    return std::unexpected(pairs.error());
  }
  TargetViews found;
  for (const std::filesystem::path& dir : *pairs) {
    if (stop && stop()) {
      found.stopped = true;
      return found;
    }
    const dataset::Loaded<Pair> pair = read_pair(dir);
    if (!pair) {
      return std::unexpected(pair.error());
    }
    if (found.width != 0 &&
        (found.width != pair->left.width || found.height != pair->left.height)) {
      return dataset::refuse(dir, "has pictures of another size than those before it",
                             "give views of one pair of cameras");
    }
    found.width = pair->left.width;
    found.height = pair->left.height;
    PairView view{.name = pair->name, .left = {}, .right = {}};
    std::string why_left;
    std::string why_right;
    view.left = corners_of(pair->left, "left", options, found.left_seen, why_left);
    view.right = corners_of(pair->right, "right", options, found.right_seen, why_right);
    const std::string& why = why_left.empty() ? why_right : why_left;
    if (!why.empty()) {
      found.refused.push_back({view.name, why});
    } else if (view.left.empty() && view.right.empty()) {
      found.refused.push_back({view.name, options.board.has_markers()
                                              ? "no eye sees enough of the board"
                                              : "no eye sees the whole board"});
    } else {
      found.views.push_back(std::move(view));
    }
  }
  found.left_mirrored = found.left_seen == 0 && mirrored(*pairs, options.board, false);
  found.right_mirrored = found.right_seen == 0 && mirrored(*pairs, options.board, true);
  return found;
}

std::string unseen(const TargetViews& views, const Board& board) {
  const std::size_t all = views.views.size() + views.refused.size();
  if (views.left_mirrored || views.right_mirrored) {
    const char* who = views.left_mirrored ? "the left camera shows" : "the right camera shows";
    who = views.left_mirrored && views.right_mirrored ? "both cameras show" : who;
    return printed(
        "%s the board mirrored: let no camera mirror its pictures, and print the board "
        "as it is",
        who);
  }
  if (views.left_seen == 0 && views.right_seen == 0) {
    return printed(
        "no picture of %zu views shows the board %s: check --board (%s), light and focus", all,
        to_string(board).c_str(),
        board.kind == Board::Kind::kAprilGrid ? "it counts tags"
                                              : "it counts inner corners, not squares");
  }
  if (views.left_seen == 0 || views.right_seen == 0) {
    const bool left = views.left_seen == 0;
    return printed(
        "the %s camera sees the board in none of %zu views, the %s one in %zu: uncover "
        "it, give it light and focus, and hold the board before both",
        left ? "left" : "right", all, left ? "right" : "left",
        std::max(views.left_seen, views.right_seen));
  }
  if (views.views.empty()) {
    const RefusedView& first = views.refused.front();
    return printed("no view of %zu counts (%s: %s): take them anew", all, first.name.c_str(),
                   first.why.c_str());
  }
  return {};
}

dataset::Loaded<TargetCalibration> calibrate_target(TargetViews views, const TargetOptions& options,
                                                    const std::function<bool()>& stop) {
  // Once true, it stays so.
  bool stopped = false;
  const auto asked = [&] { return stopped = stopped || (stop && stop()); };
  TargetCalibration result;
  result.refused = std::move(views.refused);
  Split parts = split(std::move(views.views), options.hold_out, views.width, views.height);
  result.fitted = std::move(parts.fitted);
  result.held_out = std::move(parts.held_out);
  dataset::Loaded<PairStart> start =
      start_of(options.board, result.fitted, views.width, views.height);
  if (!start) {
    return too_few(result, start.error());
  }
  std::optional<PairFit> fit = fit_without_outliers(options, std::move(*start), asked, result);
  if (stopped) {
    return dataset::refuse("stopped");
  }
  if (!fit) {
    return dataset::refuse(
        "the lenses do not follow from these views: add near views of the board tilted by 20 to 40 "
        "degrees, to both sides and up and down");
  }
  result.fit = std::move(*fit);
  result.tangential = explains(options, {.k3 = false, .tangential = true, .stop = asked}, result);
  result.k3 =
      explains(options, {.k3 = true, .tangential = result.tangential, .stop = asked}, result);
  if (stopped) {
    return dataset::refuse("stopped");
  }
  if (const char* const why = dsp::problem_of(result.fit.rig); *why != '\0') {
    // Cameras that stand nowhere in particular are no exchanged ones.
    if (const std::optional<std::string> vague = uncertain(result.fit)) {
      return dataset::refuse(
          "the pair does not follow from these views, which are too much alike: " + *vague);
    }
    return dataset::refuse(std::string(why) +
                           ": check that left and right are not exchanged and that no camera "
                           "mirrors its pictures");
  }
  if (result.fit.corner_sigma_px > kMostCornerPx) {
    return dataset::refuse(
        printed("corners are off by %.1f px, %.1f are allowed: check that the board is flat and "
                "stiff, that --board names it, and that no camera mirrors its pictures",
                result.fit.corner_sigma_px, kMostCornerPx));
  }
  for (std::size_t n = 0; n < result.fitted.size(); ++n) {
    result.poses.push_back(
        view_pose(options.board, result.fitted[n], result.fit.boards[n], result.fit.rig));
  }
  result.missing = missing_views(result.fitted, result.poses, views.width, views.height);
  if (std::optional<std::string> vague = uncertain(result.fit)) {
    result.missing.push_back(std::move(*vague));
  }
  result.judgement = judge(options, result);
  return result;
}

std::string other_rig(const dsp::Calibration& start, const dsp::RawPair& rig) {
  const dsp::StereoRig& known = start.stereo;
  if (known.left.width == 0) {
    return {};
  }
  if (known.left.width != rig.left.width || known.left.height != rig.left.height) {
    return "is of pictures of " + dataset::size_text(known.left.width, known.left.height) +
           ", the views have " + dataset::size_text(rig.left.width, rig.left.height) +
           ": give the calibration of this rig";
  }
  const double baseline = with_pair({}, rig).stereo.baseline_m;
  if (known.baseline_m > 0 && !(std::abs(baseline / known.baseline_m - 1) <= kMostBaselineShare)) {
    return printed(
        "has a baseline of %.4f m, by the views it is %.4f m: measure a square of the "
        "board for --board, or give the calibration of this rig",
        known.baseline_m, baseline);
  }
  return {};
}

std::string other_scale(const dsp::Calibration& start, const dsp::RawPair& rig) {
  const double known = start.stereo.baseline_m;
  const double baseline = with_pair({}, rig).stereo.baseline_m;
  const double share = known > 0 ? baseline / known - 1 : 0;
  if (std::abs(share) <= kSameBaselineShare) {
    return {};
  }
  return printed(
      "the baseline is %.2f mm, %.2f mm in --start, %+.2f percent, and so is all depth: where "
      "--start was measured, the squares of the board are not as large as --board says: measure "
      "them along ten squares",
      baseline * kMm, known * kMm, share * kPercent);
}

dsp::Calibration with_pair(const dsp::Calibration& start, const dsp::RawPair& rig) {
  dsp::Calibration made = start;
  made.stereo = {};
  made.stereo.raw = rig;
  dsp::complete(made.stereo);
  if (start.pmd.lens.width == 0 || start.stereo.left.width == 0) {
    return made;
  }
  // The left camera's own axes before: those of the picture, where it was not rectified.
  Matrix3 to_left = Matrix3::Identity();
  if (start.stereo.raw) {
    to_left = matrix_of(dsp::rectify(*start.stereo.raw).left_turn).transpose();
  }
  const Matrix3 turn = matrix_of(dsp::rectify(rig).left_turn) * to_left;
  const PoseUnknowns old = pose_of(start.pmd_to_stereo);
  made.pmd_to_stereo =
      transform_of(pose_of(Matrix3(turn * rotation_of(old)), Vector3(turn * translation_of(old))));
  return made;
}

}  // namespace stof::host

#include "host/calibrate/rig/live/view_guide.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kFewestShared = 4;
// Of the picture's width: views whose corners are nearer together tell the same.
constexpr double kLeastChange = 0.04;
// One more of each kind than a fit needs, because some views are held out.
constexpr std::size_t kOfEachTilt = 2;
constexpr std::size_t kNearViews = 2;
constexpr std::size_t kFarViews = 2;
constexpr std::array<const char*, 8> kCornerNames{
    "upper left of the left picture",  "upper right of the left picture",
    "lower left of the left picture",  "lower right of the left picture",
    "upper left of the right picture", "upper right of the right picture",
    "lower left of the right picture", "lower right of the right picture"};

// rms of the distance between corners that both show; none of fewer than kFewestShared.
std::optional<double> apart(const std::vector<PixelPoint>& a, const std::vector<PixelPoint>& b) {
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (a[i].seen() && b[i].seen()) {
      const double du = a[i].u - b[i].u;
      const double dv = a[i].v - b[i].v;
      squares += du * du + dv * dv;
      ++count;
    }
  }
  return count < kFewestShared ? std::nullopt
                               : std::optional(std::sqrt(squares / static_cast<double>(count)));
}

double blur_of(const Sighting& seen) {
  double most = 0;
  for (const auto& [corners, blur] : {std::pair(&seen.corners.left, seen.left_blur_px),
                                      std::pair(&seen.corners.right, seen.right_blur_px)}) {
    // NaN, where there was no contrast, is as bad as can be.
    if (!corners->empty()) {
      most = std::isfinite(blur) ? std::max(most, blur) : HUGE_VAL;
    }
  }
  return most;
}

}  // namespace

std::optional<double> corner_motion(const PairView& before, const PairView& now) {
  const std::optional<double> left = apart(before.left, now.left);
  const std::optional<double> right = apart(before.right, now.right);
  if (left && right) {
    return std::max(*left, *right);
  }
  return left ? left : right;
}

ViewJudgement ViewGuide::judge(const Sighting& rough, const std::function<Sighting()>& look) {
  ViewJudgement judgement;
  const PairView& now = rough.corners;
  if (now.left.empty() && now.right.empty()) {
    before_.reset();
    return judgement;
  }
  const std::optional<double> motion =
      before_ ? corner_motion(*before_, now) : std::optional<double>();
  before_ = now;
  judgement.motion_px = motion.value_or(judgement.motion_px);
  if (!(judgement.motion_px <= options_.most_motion_px)) {
    judgement.verdict = ViewVerdict::kMoving;
  } else if (known(now)) {
    judgement.verdict = ViewVerdict::kKnown;
  } else if (!serves(now)) {
    judgement.verdict = ViewVerdict::kNeedless;
  } else {
    const Sighting seen = look();
    judgement.blur_px = blur_of(seen);
    judgement.verdict =
        judgement.blur_px <= options_.most_blur_px ? ViewVerdict::kTaken : ViewVerdict::kBlurred;
    if (judgement.verdict == ViewVerdict::kTaken) {
      add(seen);
    }
  }
  return judgement;
}

void ViewGuide::add(const Sighting& view) {
  views_.push_back(view.corners);
  if (view.pose) {
    poses_.push_back(*view.pose);
  }
}

void ViewGuide::want_more(std::size_t count) {
  options_.views = count + static_cast<std::size_t>(std::ranges::count_if(views_, &PairView::both));
}

bool ViewGuide::known(const PairView& corners) const {
  return std::ranges::any_of(views_, [&](const PairView& view) {
    const std::optional<double> motion = corner_motion(view, corners);
    // What one eye alone saw before is new where both see it.
    return motion && *motion < kLeastChange * options_.width && (view.both() || !corners.both());
  });
}

bool ViewGuide::serves(const PairView& corners) const {
  if (corners.both()) {
    return true;
  }
  const unsigned reached = reached_corners({corners}, options_.width, options_.height);
  return (reached & ~reached_corners(views_, options_.width, options_.height)) != 0;
}

std::size_t ViewGuide::far_views() const {
  double largest = 0;
  for (const ViewPose& pose : poses_) {
    largest = std::max(largest, pose.share);
  }
  return static_cast<std::size_t>(std::ranges::count_if(poses_, [&](const ViewPose& pose) {
    return std::sqrt(pose.share) <= kFarRatio * std::sqrt(largest);
  }));
}

std::vector<ViewWant> ViewGuide::wants() const {
  const auto count = [&](auto&& good) {
    return static_cast<std::size_t>(std::ranges::count_if(poses_, good));
  };
  std::vector<ViewWant> wants;
  wants.push_back(
      {"near", printed("near: the board fills %.0f percent of a picture or more", kNearShare * 100),
       count([](const ViewPose& pose) { return pose.share >= kNearShare; }), kNearViews});
  wants.push_back(
      {"far", "far: the board from twice as far as the nearest", far_views(), kFarViews});
  wants.push_back({"left-away",
                   "tilted: the board's left side away from the cameras, 15 degrees "
                   "or more",
                   count([](const ViewPose& p) { return p.sideways_rad <= -kLeastTiltRad; }),
                   kOfEachTilt});
  wants.push_back({"right-away", "tilted: the board's right side away from the cameras",
                   count([](const ViewPose& p) { return p.sideways_rad >= kLeastTiltRad; }),
                   kOfEachTilt});
  wants.push_back({"top-away", "tilted: the board's top away from the cameras",
                   count([](const ViewPose& p) { return p.upwards_rad <= -kLeastTiltRad; }),
                   kOfEachTilt});
  wants.push_back({"bottom-away", "tilted: the board's bottom away from the cameras",
                   count([](const ViewPose& p) { return p.upwards_rad >= kLeastTiltRad; }),
                   kOfEachTilt});
  const unsigned reached = reached_corners(views_, options_.width, options_.height);
  for (std::size_t i = 0; i < kCornerNames.size(); ++i) {
    wants.push_back({printed("corner %zu", i),
                     std::string("corners: the board in the ") + kCornerNames[i],
                     (reached >> i) & 1U, 1});
  }
  wants.push_back({"more", "more: the board anywhere, before both cameras",
                   static_cast<std::size_t>(std::ranges::count_if(views_, &PairView::both)),
                   options_.views});
  return wants;
}

bool ViewGuide::complete() const { return std::ranges::none_of(wants(), &ViewWant::missing); }

std::string missing_text(const std::vector<ViewWant>& wants, std::size_t most) {
  std::string text;
  std::size_t told = 0;
  std::size_t left = 0;
  for (const ViewWant& want : wants) {
    if (!want.missing()) {
      continue;
    }
    if (told == most) {
      ++left;
      continue;
    }
    text += (told++ == 0 ? "" : "; ") + want.ask;
    if (want.need > 1) {
      text += printed(" (%zu of %zu)", want.have, want.need);
    }
  }
  return left == 0 ? text : text + printed("; and %zu more", left);
}

std::string verdict_text(const ViewJudgement& judgement, const ViewGuideOptions& options) {
  switch (judgement.verdict) {
    case ViewVerdict::kNoBoard:
      return "no board is seen: hold it before both cameras, nearer where it is far";
    case ViewVerdict::kMoving:
      return std::isfinite(judgement.motion_px)
                 ? printed("hold still: corners move by %.1f px, %.1f are allowed",
                           judgement.motion_px, options.most_motion_px)
                 : "hold still: the board is seen";
    case ViewVerdict::kBlurred:
      return std::isfinite(judgement.blur_px)
                 ? printed(
                       "blurred: edges are smoothed by %.1f px, %.1f are allowed: hold still, "
                       "or focus",
                       judgement.blur_px, options.most_blur_px)
                 : "too dark: edges of the board have no contrast: more light";
    case ViewVerdict::kKnown:
      return "taken already: move on to another place or tilt";
    case ViewVerdict::kNeedless:
      return "one camera alone sees the board, and nothing new: show it to both";
    case ViewVerdict::kTaken:
      break;
  }
  return "taken";
}

}  // namespace stof::host

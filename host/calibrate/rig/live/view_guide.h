#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/rig/target/coverage.h"
#include "host/calibrate/rig/target/pair_fit.h"

// Guides whoever holds a board before a live pair: which exposures become views, and which view is
// missing. Knows no sensor, no picture, no file and no clock.
namespace stof::host {

// What one exposure shows of the board.
struct Sighting {
  // An eye that does not see enough of the board has no corners. The name is the view's, where it
  // becomes one.
  PairView corners;
  double left_blur_px = 0;  // FoundBoard::blur_px of an eye that has corners
  double right_blur_px = 0;
  // By lenses that are roughly known: 10 percent of focal length are 3 degrees of a tilt of 30.
  std::optional<ViewPose> pose;
};

// How far corners moved between two exposures, px: the larger of both eyes' rms over the corners
// that both exposures show. None where no eye shows four of them in both.
std::optional<double> corner_motion(const PairView& before, const PairView& now);

enum class ViewVerdict : std::uint8_t {
  kNoBoard,  // no eye sees enough of it
  kMoving,   // it moved since the exposure before, or that one showed no board
  kBlurred,
  kKnown,     // about as a view that was taken
  kNeedless,  // one eye alone sees it, and no corner of that eye's picture that was missing
  kTaken,
};

struct ViewJudgement {
  ViewVerdict verdict = ViewVerdict::kNoBoard;
  double motion_px = std::numeric_limits<double>::quiet_NaN();  // NaN: there is nothing to compare
  double blur_px = std::numeric_limits<double>::quiet_NaN();    // of the more blurred eye; NaN: not
                                                                // looked at, or no contrast
};

struct ViewGuideOptions {
  int width = 0;  // of the pictures
  int height = 0;
  std::size_t views = 20;     // that both eyes see
  double most_motion_px = 1;  // between successive exposures, for a view to be taken
  double most_blur_px = 1.5;  // FoundBoard::blur_px
};

// One thing that the views together must show.
struct ViewWant {
  // For programs and pictures: near, far, left-away, right-away, top-away, bottom-away, more, or
  // corner 0..7 as bits of reached_corners().
  std::string name;
  std::string ask;  // in the words of whoever holds the board
  std::size_t have = 0;
  std::size_t need = 1;
  bool missing() const { return have < need; }
};

class ViewGuide {
 public:
  explicit ViewGuide(const ViewGuideOptions& options) : options_(options) {}

  // The next exposure, seen roughly: without blur, corners to a tenth of a pixel. `look` sees it as
  // well as can be, and is asked where a view would be taken. Where it is kTaken, it is the last of
  // views().
  ViewJudgement judge(const Sighting& rough, const std::function<Sighting()>& look);
  // A view that was taken before, as by an earlier run.
  void add(const Sighting& view);

  // So many views beyond those that there are: a fit was not content.
  void want_more(std::size_t count);

  // All that is wanted, in the order in which it is best shown.
  std::vector<ViewWant> wants() const;
  bool complete() const;
  const std::vector<PairView>& views() const { return views_; }
  const ViewGuideOptions& options() const { return options_; }

 private:
  bool known(const PairView& corners) const;
  bool serves(const PairView& corners) const;
  std::size_t far_views() const;

  ViewGuideOptions options_;
  std::optional<PairView> before_;  // the newest exposure that showed the board
  std::vector<PairView> views_;
  std::vector<ViewPose> poses_;  // of those that have one
};

// "near: bring the board nearer ...; more: 12 of 20 views": the first `most` of what is missing,
// and how many more. Empty: nothing is.
std::string missing_text(const std::vector<ViewWant>& wants, std::size_t most);
// What to do, or what became of it: "hold still: corners move by 5.2 px, 1.0 are allowed".
std::string verdict_text(const ViewJudgement& judgement, const ViewGuideOptions& options);

}  // namespace stof::host

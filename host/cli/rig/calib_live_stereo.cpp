#include <utility>

#include "host/calibrate/rig/live/coverage_picture.h"
#include "host/calibrate/rig/live/sighting.h"
#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/own_keys.h"
#include "host/cli/rig/live_stereo_json.h"
#include "host/cli/rig/live_views.h"
#include "host/cli/stop_signal.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kToldAtOnce = 2;  // of what is missing, between begin and end
constexpr std::size_t kAllOfIt = 99;
constexpr std::size_t kMoreViews = 3;  // where the fit finds that some are missing
constexpr std::size_t kMostViews = 80;
constexpr int kUntold = 20;  // exposures that a lens is waited for

class LiveStereo {
 public:
  LiveStereo(const CalibStereoOptions& options, const TargetOptions& target)
      : options_(options),
        target_(target),
        kept_(live_folder(options.live, options.out, ".views"), "view"),
        lines_(options.json) {}

  // Until all views are there, with the calibration that they make.
  TargetCalibration run() {
    LiveShots shots(options_.live, false);
    tell("subscribing", "subscribing at " + options_.live.sensor + "; views are kept in " +
                            kept_.folder().string() + ", what they cover in coverage.png there");
    while (std::optional<RawShot> shot = shots.next(kept_text())) {
      // Its calibration comes with the first frames.
      if (!guide_ && !shots.told_lens() && ++untold_ < kUntold) {
        continue;
      }
      if (!guide_) {
        begin(*shot, shots.told_lens());
        if (std::optional<TargetCalibration> found = finished()) {
          return std::move(*found);
        }
      }
      if (shot->left.width != lens_.width || shot->left.height != lens_.height) {
        throw Failure(Exit::kBadInput, "the sensor's pictures changed their size; " + kept_text());
      }
      if (look_at(*shot)) {
        if (std::optional<TargetCalibration> found = finished()) {
          return std::move(*found);
        }
      }
    }
    throw Failure(Exit::kFailure,
                  shots.why() + ": " + kept_text() +
                      (guide_ ? "; missing: " + missing_text(guide_->wants(), kAllOfIt) : ""));
  }

 private:
  std::string kept_text() const {
    const std::size_t count = kept_.count();
    return count == 0 ? std::string("no view was taken")
                      : printed(
                            "views in %s: %zu; run it again to go on, or take them as they "
                            "are (stof calib stereo --target)",
                            kept_.folder().c_str(), count);
  }

  void begin(const RawShot& shot, const std::optional<dsp::Pinhole>& told) {
    lens_ = told.value_or(assumed_lens(shot.left.width, shot.left.height));
    guide_.emplace(ViewGuideOptions{.width = shot.left.width,
                                    .height = shot.left.height,
                                    .views = options_.live.views,
                                    .most_motion_px = options_.live.most_motion_px,
                                    .most_blur_px = options_.most_blur_px});
    if (!kept_.empty()) {
      tell("reading", printed("reading %zu views that were kept", kept_.count()));
      TargetViews before = value_or_fail(find_views(kept_.folder(), target_, asked_to_stop));
      if (before.stopped) {
        throw Failure(Exit::kFailure, "stopped: " + kept_text());
      }
      if (before.width != shot.left.width || before.height != shot.left.height) {
        throw Failure(Exit::kBadInput, kept_.folder().string() +
                                           ": holds views of another size than the sensor's: name "
                                           "another folder (--keep)");
      }
      for (PairView& view : before.views) {
        guide_->add(sighting_of(std::move(view), target_.board, lens_));
      }
      tell("missing",
           printed("views of before: %zu; ", guide_->views().size()) + missing(kAllOfIt));
      draw();
    } else {
      tell("missing", missing(kAllOfIt));
    }
  }

  // Whether a view was taken.
  bool look_at(const RawShot& shot) {
    const std::string name = kept_.next_name();
    const auto look = [&](Corners how) {
      return sighting_of(shot.left, shot.right, target_.board, lens_, name, how);
    };
    const Sighting rough = look(Corners::kRough);
    const ViewJudgement judgement = guide_->judge(rough, [&look] { return look(Corners::kFine); });
    const bool taken = judgement.verdict == ViewVerdict::kTaken;
    std::string text;
    if (taken) {
      keep(name, shot);
      text = printed("%s: taken (corners moved by %.2f px, edges are %.2f px wide), %zu in all; ",
                     name.c_str(), judgement.motion_px, judgement.blur_px, guide_->views().size()) +
             missing();
    } else {
      text = verdict_text(judgement, guide_->options());
      const bool elsewhere =
          judgement.verdict == ViewVerdict::kKnown || judgement.verdict == ViewVerdict::kNeedless;
      text += elsewhere ? "; " + missing() : std::string();
    }
    if (options_.json) {
      say_json_line(look_json({.shot = shot,
                               .corners = rough.corners,
                               .judgement = judgement,
                               .guide = *guide_,
                               .text = std::move(text)},
                              options_.picture_width));
    } else if (taken) {
      lines_.note(text);
    } else {
      lines_.tell(static_cast<int>(judgement.verdict), text);
    }
    return taken;
  }

  void keep(const std::string& name, const RawShot& shot) const {
    try {
      kept_.write(name, shot);
      draw();
    } catch (const Failure& failure) {
      throw Failure(failure.code(), std::string(failure.what()) + "; " + kept_text());
    }
  }

  void tell(const char* state, const std::string& text) const {
    if (options_.json) {
      say_json_line(stage_json(state, text));
    } else {
      lines_.note(text);
    }
  }

  std::string missing(std::size_t most = kToldAtOnce) const {
    const std::string text = missing_text(guide_->wants(), most);
    return text.empty() ? "all views are there" : "missing: " + text;
  }

  void draw() const {
    value_or_end(write_png(
        kept_.folder() / "coverage.png",
        coverage_picture(guide_->views(), guide_->wants(), lens_.width, lens_.height), {}));
  }

  // The fit judges the views as a whole: what it misses is asked for.
  std::optional<TargetCalibration> finished() {
    if (!guide_->complete()) {
      return std::nullopt;
    }
    tell("calibrating", "all views are there: calibrating");
    TargetViews views{
        .width = lens_.width, .height = lens_.height, .views = guide_->views(), .refused = {}};
    bool stopped = false;
    dataset::Loaded<TargetCalibration> found = calibrate_target(
        std::move(views), target_, [&stopped] { return stopped = asked_to_stop(); });
    if (stopped) {
      throw Failure(Exit::kFailure, "stopped: " + kept_text());
    }
    if (found && (found->missing.empty() || options_.force)) {
      return std::move(*found);
    }
    const std::string why = found ? found->missing.front() : found.error().message;
    if (guide_->views().size() + kMoreViews > kMostViews) {
      throw Failure(Exit::kBadInput, why + "; " + kept_text());
    }
    guide_->want_more(kMoreViews);
    tell("missing", "missing: " + why);
    return std::nullopt;
  }

  const CalibStereoOptions& options_;
  TargetOptions target_;
  KeptViews kept_;
  LiveLines lines_;
  std::optional<ViewGuide> guide_;  // from the first exposure on
  int untold_ = 0;
  dsp::Pinhole lens_;  // of both eyes, roughly; its size is the pictures'
};

}  // namespace

std::filesystem::path live_folder(const CalibLiveOptions& live, const std::filesystem::path& out,
                                  const char* ending) {
  return live.keep.empty() ? std::filesystem::path(out.string() + ending) : live.keep;
}

TargetCalibration calib_live_stereo(const CalibStereoOptions& options,
                                    const TargetOptions& target) {
  stop_on_signals();
  return LiveStereo(options, target).run();
}

}  // namespace stof::host

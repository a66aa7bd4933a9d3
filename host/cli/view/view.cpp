#include "host/cli/view/view.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "dataset/files/file.h"
#include "host/cli/failure.h"
#include "host/cli/live/frame_wait.h"
#include "host/cli/live/link_teller.h"
#include "host/cli/live/robot_state.h"
#include "host/cli/output.h"
#include "host/cli/receive.h"
#include "host/cli/sensor_text.h"
#include "host/cli/stop_signal.h"
#include "host/cli/view/frame_copy.h"
#include "host/cli/view/raw_files.h"
#include "host/cli/view/status_line.h"

namespace stof::host {
namespace {

// One reception from the first packet to the last.
class View {
 public:
  View(const ViewOptions& options, client::Receiver& receiver, PageView& page)
      : options_(options), receiver_(receiver), page_(page) {}

  // Until enough frames came, a signal, or the timeout.
  void run() {
    const client::Time began = client::Time::clock::now();
    raw_heard_ = began;
    while (!asked_to_stop() && !enough()) {
      take(receiver_.next(kLook));
      take_raw();
      say_events();
      say_link();
      const client::Time now = client::Time::clock::now();
      page_.look(options_, receiver_, now);
      if (frames_stay_away(receiver_, began, options_.timeout_s, now) && !page_.visited()) {
        silent_ = true;
        return;
      }
      if (options_.raw_count > 0 && now - raw_heard_ > raw_patience()) {
        return;
      }
      if (status_line_.due(now)) {
        say(line(now));
      }
    }
  }

  // The last lines and the files. Throws Failure when less came than was asked for.
  void finish() {
    const std::string where = place_of(receiver_);
    if (frames_ == 0) {
      throw Failure(Exit::kFailure, where + ": " + no_frame_text(receiver_, options_));
    }
    if (status_line_.pending()) {
      say(line(client::Time::clock::now()));
    }
    say(streams_);
    say(summary_line(receiver_.statistics()));
    if (options_.raw.pictures != 0) {
      say(raw_line(receiver_.raw_statistics()));
    }
    if (receiver_.health()) {
      say(health_line(*receiver_.health()));
    }
    if (!options_.headless.empty()) {
      write_last();
      say(headless_line());
    }
    if (!options_.out.empty()) {
      say((whole_.empty() ? newest_ : whole_).write(options_.out, options_.scale));
    }
    if (const std::string advice = receiver_.advice(); !advice.empty()) {
      say(advice);
    }
    if (options_.raw.pictures != 0 && (raw_ == 0 || raw_ < options_.raw_count)) {
      throw Failure(Exit::kFailure,
                    where + ": " + std::to_string(raw_) + " exposures came with all raw pictures" +
                        raw_absence(receiver_.raw_refusal(), "ask with a larger --raw-every"));
    }
    if (frames_ < options_.frames || silent_) {
      throw Failure(Exit::kFailure, where + ": the stream ended after " + std::to_string(frames_) +
                                        " frames" + ended_text(receiver_, options_, clock_));
    }
  }

 private:
  static constexpr std::chrono::milliseconds kLook{100};

  bool enough() const {
    return (options_.frames > 0 && frames_ >= options_.frames) ||
           (options_.raw_count > 0 && raw_ >= options_.raw_count);
  }

  // Without an exposure that has all raw pictures.
  std::chrono::duration<double> raw_patience() const {
    return std::chrono::duration<double>(options_.timeout_s) +
           receiver_.period() * std::max<std::int64_t>(options_.raw.every, 1);
  }

  void take_raw() {
    while (const std::optional<client::RawExposure> exposure = receiver_.take_raw()) {
      const wire::RawInfo& info = exposure->info;
      if (info.camera_width > 0 && info.width == 0) {
        throw Failure(Exit::kBadInput, "--raw-part: lies outside of the cameras' " +
                                           std::to_string(info.camera_width) + " x " +
                                           std::to_string(info.camera_height) +
                                           " pictures: name a part within them");
      }
      say(raw_exposure_line(*exposure));
      if (!options_.out.empty()) {
        write_raw(*exposure, options_.out);
      }
      if (exposure->complete()) {
        ++raw_;
        raw_heard_ = client::Time::clock::now();
      }
    }
  }

  void say_events() {
    while (const std::optional<client::ToldEvent> event = receiver_.take_event()) {
      const std::string text = event_line(event->report);
      say(text);
      page_.record(*event);
      page_.tell(event->report, text);
    }
  }

  void say_link() {
    const std::string lines =
        teller_.look(receiver_.link(), receiver_.health(), client::Time::clock::now());
    if (!lines.empty()) {
      say(lines);
    }
    for (const LinkTeller::Change& change : teller_.changes()) {
      page_.tell(change);
    }
  }

  std::string line(client::Time now) {
    // Asked before the score, which takes longer than a link may be silent.
    const client::LinkState link = receiver_.link();
    return (replay_ ? "REPLAY " : "") + status_line_.line(now, receiver_.statistics(), score()) +
           (receiver_.health() ? active_text(*receiver_.health()) : "") + link_text(link);
  }

  void take(const Result<client::Frame>& frame) {
    if (!frame) {
      if (frame.error() == Status::kDeviceLost) {
        throw Failure(Exit::kFailure, "the socket failed: start again");
      }
      return;
    }
    if (frames_ == 0) {
      say(first_frame_line(options_, receiver_, frame->origin.device_id));
    }
    clock_ = frame->stamp.clock;
    const bool replay = clock_ == wire::ClockState::kRecorded;
    if (replay && !replay_) {
      say(kReplayLine);
    }
    replay_ = replay;
    if (frames_ == 0 && !options_.truth.empty()) {
      truth_ = value_or_fail(dataset::read_pfm(options_.truth));
    }
    if (truth_ && !frame->depth.empty() &&
        (truth_->width != frame->depth.width() || truth_->height != frame->depth.height())) {
      throw Failure(Exit::kBadInput,
                    options_.truth.string() +
                        ": is not of the received frames' size: give the truth of this scene");
    }
    ++frames_;
    page_.show(*frame, times_of(*frame, receiver_));
    page_.record(*frame, receiver_);
    status_line_.count(*frame);
    streams_ = streams_line(*frame);
    FrameCopy& kept = frame->complete() ? whole_ : newest_;
    kept.keep(*frame);
    if (!options_.headless.empty() && kept.has_depth()) {
      write_depth(kept, frame->last_packet);
    }
  }

  // One that had to wait for long is left out: the newer ones behind it are written.
  void write_depth(const FrameCopy& kept, client::Time arrived) {
    constexpr std::chrono::milliseconds kMostWait{
        100};  // well below what is too old to be received
    if (client::Time::clock::now() - arrived > kMostWait) {
      ++left_out_;
      left_last_ = &kept;
      return;
    }
    left_last_ = nullptr;
    kept.write_depth(options_.headless, options_.scale);
    ++written_;
  }

  // No newer one comes behind the last.
  void write_last() {
    if (left_last_ != nullptr && left_last_->has_depth()) {
      left_last_->write_depth(options_.headless, options_.scale);
      --left_out_;
      ++written_;
    }
  }

  std::string headless_line() const {
    std::string line = "wrote " + std::to_string(written_) +
                       (written_ == 1 ? " frame" : " frames") + " to " + options_.headless.string();
    if (left_out_ != 0) {
      line +=
          ", " + std::to_string(left_out_) +
          " left out: writing takes too long; stof record, and stof export of its file, leave out "
          "none";
    }
    return line;
  }

  std::optional<DepthScore> score() const {
    if (!truth_ || !whole_.has_depth()) {
      return std::nullopt;
    }
    return score_depth(whole_.planes(), *truth_);
  }

  const ViewOptions& options_;
  client::Receiver& receiver_;
  PageView& page_;
  LinkTeller teller_;
  StatusLine status_line_;
  FrameCopy whole_;   // the newest complete frame
  FrameCopy newest_;  // the newest incomplete one
  std::optional<dataset::Image<float>> truth_;
  bool replay_ = false;  // the newest frame is of a recording
  std::string streams_;  // of the newest frame
  std::uint64_t frames_ = 0;
  std::uint64_t written_ = 0;             // frames of `headless`
  std::uint64_t left_out_ = 0;            // frames with depth that `headless` had no time for
  const FrameCopy* left_last_ = nullptr;  // the last frame with depth, where it is one of those
  std::uint64_t raw_ = 0;                 // exposures with all raw pictures
  client::Time raw_heard_{};
  wire::ClockState clock_ = wire::ClockState::kMonotonic;  // of the last frame
  bool silent_ = false;
};

}  // namespace

bool has_page(const ViewOptions& options) {
  return (options.frames == 0 && options.raw_count == 0 && options.headless.empty()) ||
         options.page.http_port || options.page.lan;
}

void view(const ViewOptions& options) {
  stop_on_signals();
  ViewOptions meant = options;
  for (const auto& [folder, flag] :
       {std::pair(&options.out, "--out"), std::pair(&options.headless, "--headless")}) {
    if (!folder->empty()) {
      need_folder(*folder, flag);
    }
  }
  client::Receiver receiver = open_receiver(meant, options.raw);
  say((options.sensor.empty() ? "listening on " : "subscribing at ") + place_of(receiver));
  PageView page;
  if (has_page(options)) {
    page.open(options.page, options, {.sensor = place_of(receiver), .scale = options.scale});
  }
  tell_port(options, receiver);
  View session(meant, receiver, page);
  session.run();
  session.finish();
}

}  // namespace stof::host

#include "host/cli/view/replay.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>

#include "host/cli/failure.h"
#include "host/cli/sensor_text.h"
#include "host/cli/stop_signal.h"
#include "host/cli/view/recorded_source.h"
#include "host/client/session/link_watch.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// What is played late is caught up with, so much of it at most.
constexpr std::chrono::nanoseconds kMostDebt = std::chrono::seconds(1);
// A pause of the recording is waited for; so much of it where nothing can be jumped over.
constexpr std::chrono::nanoseconds kMostPause = std::chrono::hours(24);
constexpr std::chrono::nanoseconds kMostFixedPause = std::chrono::seconds(10);

// What makes no sense of a recording.
void judge_replay(const ViewOptions& options) {
  const std::pair<bool, const char*> unfit[] = {
      {options.frames != 0, "--frames"},         {!options.out.empty(), "--out"},
      {!options.headless.empty(), "--headless"}, {!options.truth.empty(), "--truth"},
      {options.raw.pictures != 0, "--raw"},      {options.signed_streams, "--signed"},
  };
  for (const auto& [given, name] : unfit) {
    if (given) {
      throw Failure(Exit::kBadInput, std::string(name) + ": is for a sensor, " + options.sensor +
                                         " is a file: stof export writes its pictures");
    }
  }
}

// Plays it until a signal comes, as the page wants it.
class Player {
 public:
  Player(const ViewOptions& options, PageView& page)
      : options_(options), page_(page), source_(options.sensor) {}

  // Throws Failure where there is no frame at all.
  void run() {
    while (!asked_to_stop()) {
      std::optional<recording::RecordedFrame> frame = source_.next();
      if (!frame) {
        begin_anew();
        continue;
      }
      wait_for(frame->log_time);
      if (asked_to_stop()) {
        break;
      }
      if (std::exchange(sought_, false)) {
        continue;  // this is not the one that is wanted any more
      }
      before_ = frame->log_time;
      show(*frame);
      shown_ = true;
    }
  }

 private:
  static constexpr std::chrono::milliseconds kLook{20};

  void begin_anew() {
    if (!shown_) {
      throw Failure(Exit::kBadInput,
                    options_.sensor + ": holds no frame: stof info says what it holds");
    }
    source_.begin_anew();
    before_.reset();
    ++turns_;
  }

  // Until the frame of that time is due: while it plays at its pace; while it stands never, but for
  // one that was sought.
  void wait_for(std::uint64_t log_time) {
    client::Time looked = client::Time::clock::now();
    next_ns_ = before_ ? log_time : 0;
    due_ = before_ && log_time > *before_
               ? std::max(due_, looked - kMostDebt) + pause_of(log_time - *before_)
               : looked;
    while (!asked_to_stop()) {
      obey();
      if (sought_) {
        return;
      }
      const client::Time now = client::Time::clock::now();
      due_ += playing_ ? client::Duration(0) : now - looked;
      looked = now;
      if (std::exchange(shows_one_, false) || (playing_ && now >= due_)) {
        return;
      }
      tell(now);
      std::this_thread::sleep_for(playing_ ? std::min<client::Duration>(kLook, due_ - now) : kLook);
    }
  }

  std::chrono::nanoseconds pause_of(std::uint64_t ns) const {
    const std::chrono::nanoseconds most = source_.seekable() ? kMostPause : kMostFixedPause;
    return std::chrono::nanoseconds(std::min(ns, static_cast<std::uint64_t>(most.count())));
  }

  // The time of the recording that is played now: of the frame that is shown, or behind it, where
  // no other one comes for longer than a sensor may be silent.
  std::uint64_t place(client::Time now) const {
    const std::chrono::nanoseconds left = std::max(due_ - now, client::Duration(0));
    const auto left_ns = static_cast<std::uint64_t>(left.count());
    const std::uint64_t at = next_ns_ - std::min(next_ns_, left_ns);
    return at > at_ns_ && at - at_ns_ > silence_ns_ ? at : at_ns_;
  }

  // What the page wants.
  void obey() {
    while (const std::optional<PageDesk::Own> own = page_.take_own()) {
      const auto& [wish, answer] = *own;
      if (const auto* const play = std::get_if<viewer::SetPlaying>(&wish)) {
        playing_ = play->on;
        answer(true, "");
        tell_place();
      } else if (const auto* const to = std::get_if<viewer::SeekTo>(&wish)) {
        if (!source_.seekable()) {
          answer(false, "the file has no index: stof recover makes one");
          continue;
        }
        const std::uint64_t length =
            source_.end_ns() - std::min(source_.begin_ns(), source_.end_ns());
        source_.seek(source_.begin_ns() + std::min(to->ms * kNsOfMs, length));
        before_.reset();
        sought_ = true;
        shows_one_ = true;
        page_.tell_at_once();  // with the frame, what the sensor said then
        answer(true, "");
      } else {
        answer(false, "this is a recording already");
      }
    }
  }

  void show(const recording::RecordedFrame& frame) {
    ++(frame.missing_packets == 0 ? counts_.frames_complete : counts_.frames_incomplete);
    counts_.packets_missing += frame.missing_packets;
    page_.show(frame.view(), {.first_packet_ns = static_cast<std::int64_t>(frame.log_time)});
    say_happenings();
    at_ns_ = frame.log_time;
    next_ns_ = 0;
    health_ = source_.health(at_ns_);  // now: behind the last frame the source begins anew
    const std::chrono::nanoseconds period(frame.calibration ? frame.calibration->period_ns : 0);
    silence_ns_ = static_cast<std::uint64_t>(
        std::chrono::nanoseconds(
            client::silence_after(std::clamp(period, std::chrono::nanoseconds(0),
                                             std::chrono::nanoseconds(client::kLongestPeriod))))
            .count());
    tell_place();
    tell(client::Time::clock::now());
  }

  // In the first turn alone: the page keeps the list.
  void say_happenings() {
    const std::vector<RecordedSource::Happening>& all = source_.happenings();
    for (; turns_ == 0 && told_ < all.size(); ++told_) {
      const std::uint64_t at_ms = all[told_].log_time / kNsOfMs;
      if (const auto* const event = std::get_if<wire::EventReport>(&all[told_].what)) {
        page_.tell(*event, event_line(*event), at_ms);
      } else {
        page_.tell(std::get<LinkTeller::Change>(all[told_].what), at_ms);
      }
    }
  }

  void tell(client::Time now) {
    const std::uint64_t at = place(now);
    if (at == at_ns_) {
      page_.tell_recorded(counts_, health_, "", now);
      return;
    }
    const double gap_s = static_cast<double>(next_ns_ - at_ns_) / 1e9;
    if (page_.tell_recorded(counts_, source_.health(at),
                            printed("the recording has nothing here for %.1f s", gap_s), now)) {
      tell_place();
    }
  }

  void tell_place() {
    const std::uint64_t begin = source_.begin_ns();
    const std::uint64_t at = place(client::Time::clock::now());
    page_.tell({.playing = playing_,
                .seekable = source_.seekable(),
                .at_ms = (std::max(at, begin) - begin) / kNsOfMs,
                .length_ms = (std::max(source_.end_ns(), begin) - begin) / kNsOfMs,
                .began_ms = begin / kNsOfMs});
  }

  static constexpr std::uint64_t kNsOfMs = 1'000'000;

  const ViewOptions& options_;
  PageView& page_;
  RecordedSource source_;
  client::Statistics counts_{};
  std::optional<std::uint64_t> before_;  // log time of the frame before
  client::Time due_;
  std::uint64_t at_ns_ = 0;       // log time of the frame that is shown
  std::uint64_t next_ns_ = 0;     // of the one that waits behind it; 0: of none
  std::uint64_t silence_ns_ = 0;  // behind the one that is shown nothing is missed for so long
  std::optional<wire::HealthReport> health_;  // of that frame
  bool playing_ = true;
  bool sought_ = false;     // the frame that waits is not wanted
  bool shows_one_ = false;  // also while it stands
  bool shown_ = false;
  std::size_t told_ = 0;  // happenings
  std::uint64_t turns_ = 0;
};

}  // namespace

void replay(const ViewOptions& options) {
  judge_replay(options);
  stop_on_signals();
  PageView page;
  Player player(options, page);
  page.open(options.page, options,
            {.sensor = std::filesystem::path(options.sensor).filename().string(),
             .scale = options.scale,
             .recording = true});
  player.run();
}

}  // namespace stof::host

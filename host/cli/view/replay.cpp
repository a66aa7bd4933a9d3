#include "host/cli/view/replay.h"

#include <algorithm>
#include <cstdio>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "host/cli/failure.h"
#include "host/cli/sensor_text.h"
#include "host/cli/stop_signal.h"
#include "host/recording/indexed_frames.h"
#include "host/recording/recording.h"

namespace stof::host {
namespace {

// A pause of the recording is not waited for longer than this.
constexpr std::chrono::nanoseconds kMostPause = std::chrono::seconds(1);

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

// Where the frames come from: by the index, from any time on, or without one from the begin.
class Source {
 public:
  // Throws Failure.
  explicit Source(const std::string& file) : file_(file) {
    if (auto indexed = recording::IndexedFrames::open(file)) {
      indexed_.emplace(std::move(*indexed));
    } else {
      begin_anew();
    }
  }

  bool seekable() const { return indexed_.has_value(); }
  // Without an index of the first frame that was read; the end is not known.
  std::uint64_t begin_ns() const { return indexed_ ? indexed_->begin_ns() : first_ns_; }
  std::uint64_t end_ns() const { return indexed_ ? indexed_->end_ns() : 0; }

  void begin_anew() {
    if (indexed_) {
      indexed_->seek(0);
    } else {
      ordered_.emplace(value_or_fail(recording::FrameReader::open(file_)));
    }
  }
  // Only where it is seekable.
  void seek(std::uint64_t log_time) { indexed_->seek(log_time); }
  std::optional<recording::RecordedFrame> next() {
    if (indexed_) {
      return indexed_->next();
    }
    std::optional<recording::RecordedFrame> frame = ordered_->next();
    if (frame && first_ns_ == 0) {
      first_ns_ = frame->log_time;
    }
    return frame;
  }

  // As far as is known now.
  std::span<const std::pair<std::uint64_t, wire::EventReport>> events() const {
    return indexed_ ? std::span(indexed_->events()) : std::span(ordered_->sights().events);
  }
  // Of the frame of that time, which was read last.
  std::optional<wire::HealthReport> health(std::uint64_t log_time) const {
    return indexed_ ? indexed_->health(log_time)
                    : recording::health_at(ordered_->sights(), log_time);
  }

 private:
  std::string file_;
  std::optional<recording::IndexedFrames> indexed_;
  std::optional<recording::FrameReader> ordered_;
  std::uint64_t first_ns_ = 0;
};

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
    if (before_ && log_time > *before_) {
      due_ = std::max(due_, client::Time::clock::now() - kMostPause) +
             std::min<std::chrono::nanoseconds>(std::chrono::nanoseconds(log_time - *before_),
                                                kMostPause);
    } else {
      due_ = client::Time::clock::now();
    }
    while (!asked_to_stop()) {
      obey();
      if (sought_) {
        return;
      }
      const client::Time now = client::Time::clock::now();
      if (std::exchange(shows_one_, false) || (playing_ && now >= due_)) {
        return;
      }
      if (!playing_) {
        due_ = now;  // it goes on at once
      }
      tell(now);
      std::this_thread::sleep_for(playing_ ? std::min<client::Duration>(kLook, due_ - now) : kLook);
    }
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
    // An event is told in the first turn alone: the page keeps the list.
    const auto events = source_.events();
    for (; turns_ == 0 && events_ < events.size(); ++events_) {
      const auto& [log_time, event] = events[events_];
      page_.tell(event, event_line(event), log_time / kNsOfMs);
    }
    at_ns_ = frame.log_time;
    tell_place();
    tell(client::Time::clock::now());
  }

  void tell(client::Time now) { page_.tell_recorded(counts_, source_.health(at_ns_), now); }

  void tell_place() {
    const std::uint64_t begin = source_.begin_ns();
    page_.tell({.playing = playing_,
                .seekable = source_.seekable(),
                .at_ms = (std::max(at_ns_, begin) - begin) / kNsOfMs,
                .length_ms = (std::max(source_.end_ns(), begin) - begin) / kNsOfMs,
                .began_ms = begin / kNsOfMs});
  }

  static constexpr std::uint64_t kNsOfMs = 1'000'000;

  const ViewOptions& options_;
  PageView& page_;
  Source source_;
  client::Statistics counts_{};
  std::optional<std::uint64_t> before_;  // log time of the frame before
  client::Time due_;
  std::uint64_t at_ns_ = 0;
  bool playing_ = true;
  bool sought_ = false;     // the frame that waits is not wanted
  bool shows_one_ = false;  // also while it stands
  bool shown_ = false;
  std::size_t events_ = 0;  // told
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

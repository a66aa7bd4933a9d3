#include "host/cli/view/replay.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <thread>

#include "host/cli/failure.h"
#include "host/cli/sensor_text.h"
#include "host/cli/stop_signal.h"
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

// Until then, or a signal.
void sleep_until(client::Time then) {
  constexpr std::chrono::milliseconds kLook{50};
  while (!asked_to_stop() && client::Time::clock::now() < then) {
    std::this_thread::sleep_for(
        std::min<client::Duration>(kLook, then - client::Time::clock::now()));
  }
}

// Of all turns.
class Replay {
 public:
  explicit Replay(PageView& page) : page_(page) {}

  // The whole file once: how many frames it has.
  std::uint64_t turn(recording::FrameReader& reader) {
    std::uint64_t frames = 0;
    std::optional<std::uint64_t> before;
    client::Time due = client::Time::clock::now();
    while (!asked_to_stop()) {
      const std::optional<recording::RecordedFrame> frame = reader.next();
      if (!frame) {
        break;
      }
      if (before && frame->log_time > *before) {
        due += std::min<std::chrono::nanoseconds>(
            std::chrono::nanoseconds(frame->log_time - *before), kMostPause);
      }
      before = frame->log_time;
      sleep_until(due);
      show(*frame);
      tell(reader.sights());
      ++frames;
    }
    ++turns_;
    return frames;
  }

 private:
  void show(const recording::RecordedFrame& frame) {
    ++(frame.missing_packets == 0 ? counts_.frames_complete : counts_.frames_incomplete);
    counts_.packets_missing += frame.missing_packets;
    page_.show(frame.view());
  }

  // An event is told in the first turn alone: the page keeps the list.
  void tell(const recording::Sights& sights) {
    for (; turns_ == 0 && events_ < sights.events.size(); ++events_) {
      const wire::EventReport& event = sights.events[events_].second;
      page_.tell(event, event_line(event));
    }
    page_.tell_recorded(
        counts_, sights.health.empty() ? std::nullopt : std::optional(sights.health.back().second),
        client::Time::clock::now());
  }

  PageView& page_;
  client::Statistics counts_{};
  std::size_t events_ = 0;  // told
  std::uint64_t turns_ = 0;
};

}  // namespace

void replay(const ViewOptions& options) {
  judge_replay(options);
  stop_on_signals();
  PageView page;
  std::optional<Replay> turns;
  while (!asked_to_stop()) {
    auto reader = recording::FrameReader::open(options.sensor);
    if (!reader) {
      throw Failure(Exit::kBadInput, reader.error().message);
    }
    if (!turns) {
      page.open(options.page, {.sensor = std::filesystem::path(options.sensor).filename().string(),
                               .scale = options.scale,
                               .recording = true});
      turns.emplace(page);
    }
    if (turns->turn(*reader) == 0 && !asked_to_stop()) {
      throw Failure(Exit::kBadInput,
                    options.sensor + ": holds no frame: stof info says what it holds");
    }
  }
}

}  // namespace stof::host

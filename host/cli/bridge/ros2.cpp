#include "host/cli/bridge/ros2.h"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <system_error>
#include <thread>
#include <utility>

#include "host/bridge/dds/publisher.h"
#include "host/bridge/robot_feed.h"
#include "host/cli/failure.h"
#include "host/cli/live/robot_state.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor_text.h"
#include "host/cli/stop_signal.h"
#include "host/recording/recording.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr std::chrono::milliseconds kLook{50};

std::int64_t wall_ns() {
  return std::chrono::duration_cast<nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}
std::int64_t count_ns(client::Time time) {
  return std::chrono::duration_cast<nanoseconds>(time.time_since_epoch()).count();
}

void say(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

// A line a frame, to measure.
class TimesFile {
 public:
  explicit TimesFile(const std::filesystem::path& path) : path_(path) {
    if (!path.empty()) {
      file_.open(path, std::ios::trunc);
      check();
    }
  }
  void add(std::uint32_t number, std::int64_t stamp_ns, std::int64_t last_packet_ns) {
    if (file_.is_open()) {
      file_ << number << ' ' << stamp_ns << ' ' << last_packet_ns << ' ' << wall_ns() << '\n';
      file_.flush();
      check();
    }
  }

 private:
  void check() const {
    if (!file_) {
      throw Failure(Exit::kBadInput, "--times " + path_.string() + ": cannot be written");
    }
  }
  std::filesystem::path path_;
  std::ofstream file_;
};

// A sensor that runs: frames as they come, for as long as nobody ends it.
class LiveBridge {
 public:
  LiveBridge(const BridgeOptions& options, bridge::RobotFeed& feed)
      : options_(static_cast<const ReceiveOptions&>(options)),
        feed_(feed),
        times_(options.times),
        receiver_(open_receiver(options_)) {
    say("publishing " + place_of(*receiver_) + " as /" + options.name_space +
        "/depth/image_raw and its neighbours, DDS domain " + std::to_string(options.domain));
    if (const std::string advice = receiver_->advice(); !advice.empty()) {
      say(advice);
    }
    tell_port(options_, *receiver_);
  }

  void run() {
    while (!asked_to_stop()) {
      if (!receiver_) {
        reopen();
        continue;
      }
      const Result<client::Frame> frame = receiver_->next(kLook);
      if (frame) {
        show(*frame);
      } else if (frame.error() == Status::kDeviceLost) {
        say("the socket failed: opening it again");
        receiver_.reset();
      }
      tell_state();
    }
  }

 private:
  void show(const client::Frame& frame) {
    const bridge::RobotFeed::Times times = times_of(frame, *receiver_);
    const std::int64_t stamp = feed_.show(frame, times);
    times_.add(frame.stamp.number, stamp, count_ns(frame.last_packet) + times.wall_offset_ns);
    if (origin_ != frame.origin.session_id) {
      say(first_frame_line(options_, *receiver_, frame.origin.device_id) +
          (origin_ ? ", which has started again" : ""));
      if (frame.stamp.clock == wire::ClockState::kRecorded) {
        say(kReplayLine);
      }
      origin_ = frame.origin.session_id;
    }
  }

  // The state as diagnostics, once a second and when frames stop or come again.
  void tell_state() {
    if (!receiver_) {
      tell({.trouble = "this computer's socket failed"});
      return;
    }
    const client::LinkState state = receiver_->link();
    std::string trouble;
    if (state.silent) {
      trouble = printed("no frame for %.1f s",
                        std::chrono::duration<double>(
                            state.frame_age.value_or(client::Time::clock::now() - began_))
                            .count()) +
                silence_text(*receiver_, options_.device);
    }
    const bridge::RobotFeed::Link link = link_of(*receiver_, std::move(trouble));
    while (const std::optional<client::ToldEvent> event = receiver_->take_event()) {
      say(event_line(event->report));
      told_.reset();
    }
    tell(link);
  }

  void tell(const bridge::RobotFeed::Link& link) {
    const client::Time now = client::Time::clock::now();
    const bool trouble = !link.trouble.empty();
    if (trouble != trouble_) {
      say(trouble ? link.trouble : "frames come");
      trouble_ = trouble;
      told_.reset();
    }
    if (!told_ || now - *told_ >= seconds(1)) {
      told_ = now;
      feed_.tell(link, wall_ns());
    }
  }

  void reopen() {
    std::this_thread::sleep_for(kLook);
    tell_state();
    try {
      receiver_.emplace(open_receiver(options_));
    } catch (const Failure&) {
      receiver_.reset();  // the network is away: again
    }
  }

  ReceiveOptions options_;
  bridge::RobotFeed& feed_;
  TimesFile times_;
  std::optional<client::Receiver> receiver_;  // none: its socket failed
  client::Time began_ = client::Time::clock::now();
  std::optional<std::uint32_t> origin_;  // session of the newest frame
  std::optional<client::Time> told_;
  bool trouble_ = false;
};

// A recording: its frames at the pace at which they came, with the stamps of then.
class FileBridge {
 public:
  FileBridge(const BridgeOptions& options, bridge::RobotFeed& feed, bridge::Publisher& publisher)
      : options_(options), feed_(feed), publisher_(publisher), times_(options.times) {}

  void run() {
    do {
      turn(value_or_fail(recording::FrameReader::open(options_.sensor)));
    } while (options_.loop && !asked_to_stop());
    constexpr std::chrono::milliseconds kLastWords{1000};
    publisher_.drain(kLastWords);
  }

 private:
  void turn(recording::FrameReader reader) {
    constexpr nanoseconds kMostPause = seconds(1);
    std::optional<std::uint64_t> before;
    client::Time due = client::Time::clock::now();
    std::uint64_t frames = 0;
    while (!asked_to_stop()) {
      const std::optional<recording::RecordedFrame> frame = reader.next();
      if (!frame) {
        break;
      }
      if (frames++ == 0) {
        await_reader();
        due = client::Time::clock::now();
      } else if (frame->log_time > *before) {
        due += std::min<nanoseconds>(nanoseconds(frame->log_time - *before), kMostPause);
      }
      before = frame->log_time;
      sleep_until(due);
      show(*frame, reader.sights());
    }
    if (frames == 0 && !asked_to_stop()) {
      throw Failure(Exit::kBadInput,
                    options_.sensor + ": holds no frame: stof info says what it holds");
    }
    say(std::to_string(frames) + " frames of " + options_.sensor);
  }

  // Else a short recording is over before anybody has found it.
  void await_reader() {
    say("publishing " + options_.sensor + " as /" + options_.name_space +
        "/depth/image_raw and its neighbours, DDS domain " + std::to_string(options_.domain) +
        ", once somebody reads");
    while (!asked_to_stop() && !publisher_.wanted(bridge::Topic::kDepth) &&
           !publisher_.wanted(bridge::Topic::kPoints)) {
      std::this_thread::sleep_for(kLook);
    }
    sleep_until(client::Time::clock::now() + seconds(1));  // its other readers, and it us
  }

  static void sleep_until(client::Time then) {
    while (!asked_to_stop() && client::Time::clock::now() < then) {
      std::this_thread::sleep_for(
          std::min<client::Duration>(kLook, then - client::Time::clock::now()));
    }
  }

  void show(const recording::RecordedFrame& recorded, const recording::Sights& sights) {
    const client::Frame frame = recorded.view();
    const auto came = static_cast<std::int64_t>(recorded.log_time);
    const std::int64_t stamp = feed_.show(frame, {.first_packet_ns = came});
    times_.add(frame.stamp.number, stamp, came);
    bridge::RobotFeed::Link link{.place = options_.sensor, .recording = true};
    if (!sights.health.empty()) {
      link.health = sights.health.back().second;
    }
    const client::Time now = client::Time::clock::now();
    if (!told_ || now - *told_ >= seconds(1)) {
      told_ = now;
      feed_.tell(link, wall_ns());
    }
  }

  const BridgeOptions& options_;
  bridge::RobotFeed& feed_;
  bridge::Publisher& publisher_;
  TimesFile times_;
  std::optional<client::Time> told_;
};

}  // namespace

void bridge_ros2(const BridgeOptions& options, const bridge::Mount& mount) {
  stop_on_signals();
  if (is_recorded(options.sensor)) {
    value_or_fail(recording::FrameReader::open(options.sensor));
  }
  auto publisher = bridge::Publisher::open({.domain = options.domain,
                                            .fragment = options.fragment,
                                            .datagram = options.datagram,
                                            .name_space = options.name_space});
  if (!publisher) {
    throw Failure(Exit::kFailure, publisher.error());
  }
  bridge::RobotFeed feed(
      *publisher,
      {.name_space = options.name_space, .cloud_step = options.cloud_step, .mount = mount});
  feed.place_frames(wall_ns());
  if (is_recorded(options.sensor)) {
    FileBridge(options, feed, *publisher).run();
  } else {
    LiveBridge(options, feed).run();
  }
}

}  // namespace stof::host

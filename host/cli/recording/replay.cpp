#include "host/cli/recording/replay.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <optional>
#include <random>
#include <variant>

#include <nlohmann/json.hpp>

#include "dataset/files/file.h"
#include "firmware/wire/crypto/crypto.h"
#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/stop_signal.h"
#include "host/client/control/subscription.h"
#include "host/recording/replay/recorded_packets.h"
#include "host/recording/replay/replay_server.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using recording::Time;

constexpr std::chrono::milliseconds kServePart{50};
constexpr std::chrono::seconds kHealthPeriod{1};
constexpr std::uint64_t kHealthRepeatedNs = 1'500'000'000;  // the next one is due earlier
constexpr std::uint64_t kMostPauseNs = 10'000'000'000;      // between two sessions
constexpr std::chrono::seconds kCalibrationPeriod{1};
constexpr client::Duration kStart =
    client::Subscription::kSilence + 2 * client::Subscription::kRepeat;
// Datagrams that go out at once, and the least time between two such bursts.
constexpr std::size_t kBurst = 8;
constexpr std::chrono::microseconds kGap{50};

std::uint32_t session_other_than(std::uint32_t recorded) {
  std::random_device random;
  std::uint32_t session = random();
  while (session == recorded) {
    session = random();
  }
  return session;
}

// What the sensor said beside its frames.
struct Beside {
  std::uint64_t log_time = 0;
  std::uint32_t session = 0;
  std::variant<wire::HealthReport, wire::EventReport> said{};
};

// In the order in which it was said.
class BesideQueue {
 public:
  // What was read since the last call.
  void collect(const recording::Sights& sights) {
    while (health_ < sights.health.size() || events_ < sights.events.size()) {
      const bool health = health_ < sights.health.size() &&
                          (events_ == sights.events.size() ||
                           sights.health[health_].first < sights.events[events_].first);
      if (health) {
        const auto& [log_time, report] = sights.health[health_];
        waiting_.push_back({log_time, sights.health_sessions[health_++], report});
      } else {
        const auto& [log_time, report] = sights.events[events_];
        waiting_.push_back({log_time, sights.event_sessions[events_++], report});
      }
    }
  }

  const Beside* first() const { return waiting_.empty() ? nullptr : &waiting_.front(); }
  void pop() { waiting_.pop_front(); }
  // How many of them are of the session that ends, in which this health was the last one. Where the
  // uptime falls the sensor has started again, whatever session is named there, and an event of
  // that moment is of that start.
  std::size_t of_session(std::uint32_t session, std::optional<wire::HealthReport> health) const {
    constexpr std::uint64_t kMomentNs = 100'000'000;
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
      const auto* const report = std::get_if<wire::HealthReport>(&waiting_[i].said);
      if (waiting_[i].session != session) {
        return i;
      }
      if (report != nullptr && health && report->uptime_ms < health->uptime_ms) {
        while (i > 0 && waiting_[i].log_time - waiting_[i - 1].log_time < kMomentNs) {
          --i;
        }
        return i;
      }
      health = report != nullptr ? *report : health;
    }
    return waiting_.size();
  }
  // A session of which there is no frame is not played.
  void forget_all_but(std::uint32_t one, std::uint32_t other) {
    std::erase_if(waiting_, [=](const Beside& beside) {
      return beside.session != one && beside.session != other;
    });
  }

 private:
  std::deque<Beside> waiting_;
  std::size_t health_ = 0;  // collected
  std::size_t events_ = 0;
};

// One recording on its way to subscribers, as often as it is played.
class Player {
 public:
  Player(const ReplayOptions& options, recording::ReplayServer& server)
      : options_(options), server_(server) {}

  // From begin to end, or until interrupted.
  void play(recording::FrameReader&& reader) {
    reader_.emplace(std::move(reader));
    packets_.reset();
    beside_ = {};
    while (!over()) {
      const std::optional<recording::RecordedFrame> frame = reader_->next();
      beside_.collect(reader_->sights());
      if (!frame) {
        break;
      }
      take(*frame);
    }
    if (packets_) {
      tell_beside(beside_.of_session(recorded_.session_id, health_));
    }
    damaged_ = reader_->damaged();
    ++passes_;
  }

  // Interrupted, or nobody came.
  bool over() const { return given_up_ || asked_to_stop(); }
  bool given_up() const { return given_up_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t healths() const { return healths_; }
  std::uint64_t events() const { return events_; }
  std::uint64_t not_whole() const { return not_whole_; }
  std::uint64_t passes() const { return passes_; }
  std::uint64_t damaged() const { return damaged_; }

 private:
  void take(const recording::RecordedFrame& frame) {
    if (!packets_) {
      begin_session(frame, frame.log_time);
      begin_after_subscription();
      if (passes_ > 0) {
        let_ask();
      }
    } else if (recorded_.session_id != frame.origin.session_id) {
      end_session(frame);
    }
    while (!over() && beside_.first() != nullptr && beside_.first()->log_time < frame.log_time) {
      tell_beside(1);
    }
    wait_for(frame.log_time);
    if (over()) {
      return;
    }
    const auto datagrams = packets_->frame(frame);
    if (!datagrams) {
      ++not_whole_;
      return;
    }
    send_beside(frame);
    send_paced(*datagrams);
    ++frames_;
  }

  // Stamps and numbers of each pass begin anew: so does the session, and it is never the sensor's.
  void begin_session(const recording::RecordedFrame& frame, std::uint64_t log_time) {
    recorded_ = frame.origin;
    const wire::Origin origin{.device_id = frame.origin.device_id,
                              .session_id = session_other_than(frame.origin.session_id)};
    packets_.emplace(origin);
    server_.set_origin(origin);
    calibration_due_ = {};
    health_.reset();
    first_log_time_ = played_until_ = log_time;
    began_ = Time::clock::now();
  }

  // The sensor has started again: what it had said before belongs to the session that ends. Two
  // recordings in one file may lie days apart.
  void end_session(const recording::RecordedFrame& frame) {
    tell_beside(beside_.of_session(recorded_.session_id, health_));
    beside_.forget_all_but(recorded_.session_id, frame.origin.session_id);
    const std::uint64_t begin = beside_.first() != nullptr
                                    ? std::min(beside_.first()->log_time, frame.log_time)
                                    : frame.log_time;
    if (begin > played_until_) {
      wait_for(played_until_ + std::min(begin - played_until_, kMostPauseNs));
    }
    begin_session(frame, begin);
    let_ask();
  }

  // No client believes a start that it was not told of when it asked, and it asks after half a
  // second of nothing.
  void let_ask() {
    serve_until(Time::clock::now() + kStart);
    began_ = Time::clock::now();
  }

  // Who subscribes sees it from its begin on.
  void begin_after_subscription() {
    if (server_.begun() != 0) {
      return;
    }
    const Time since = Time::clock::now();
    while (!asked_to_stop() && server_.subscribers() == 0) {
      serve_until(Time::clock::now() + kServePart);
      if (options_.timeout_s > 0 &&
          Time::clock::now() - since > std::chrono::duration<double>(options_.timeout_s)) {
        given_up_ = true;
        return;
      }
    }
    began_ = Time::clock::now();
  }

  void serve_until(Time time) {
    if (!server_.serve_until(time)) {
      throw Failure(Exit::kFailure, "the socket failed: start again");
    }
  }

  Time due(std::uint64_t log_time) const {
    const double since_ns =
        log_time > first_log_time_ ? static_cast<double>(log_time - first_log_time_) : 0;
    return began_ + std::chrono::duration_cast<Time::duration>(
                        std::chrono::duration<double, std::nano>(since_ns / options_.rate));
  }

  void wait_for(std::uint64_t log_time) {
    const Time time = due(log_time);
    Time now = Time::clock::now();
    do {
      serve_until(std::min(time, now + kServePart));
      now = Time::clock::now();
      repeat_health(now);
    } while (now < time && !over());
    played_until_ = std::max(played_until_, log_time);
  }

  // The next ones of what the sensor said beside its frames, each when it said it.
  void tell_beside(std::size_t count) {
    for (; count > 0 && !over(); --count) {
      const Beside beside = *beside_.first();
      beside_.pop();
      const auto* const health = std::get_if<wire::HealthReport>(&beside.said);
      if (health != nullptr) {
        keep_believable(*health, beside.log_time);
      }
      wait_for(beside.log_time);
      if (over()) {
        return;
      }
      if (health != nullptr) {
        health_ = *health;
        health_log_time_ = beside.log_time;
        repeat_until_ =
            Time::clock::now() + (due(beside.log_time + kHealthRepeatedNs) - due(beside.log_time));
        send_health();
        ++healths_;
      } else {
        send_one(packets_->event(std::get<wire::EventReport>(beside.said)));
        ++events_;
      }
    }
  }

  // Clients believe an uptime that advances as their own clock, and up to 2 s more: where the
  // sensor had said nothing for a while a faster replay has to wait.
  void keep_believable(const wire::HealthReport& health, std::uint64_t log_time) {
    constexpr std::chrono::milliseconds kAhead{1500};
    constexpr std::uint64_t kNsPerMs = 1'000'000;
    if (!health_ || health.uptime_ms <= health_->uptime_ms) {
      return;
    }
    const std::uint64_t step_ms = health.uptime_ms - health_->uptime_ms;
    const std::uint64_t recorded_ms =
        (log_time - std::min(log_time, health_log_time_)) / kNsPerMs + kAhead.count();
    const Time earliest =
        health_sent_ + std::chrono::milliseconds(std::min(step_ms, recorded_ms)) - kAhead;
    began_ += std::max(earliest - due(log_time), Time::duration(0));
  }

  // Once a second where the sensor did, too: a slower replay, and who subscribes later.
  void repeat_health(Time now) {
    if (health_ && now >= health_sent_ + kHealthPeriod && now < repeat_until_) {
      send_health();
    }
  }

  void send_health() {
    health_sent_ = Time::clock::now();
    send_one(packets_->health(*health_));
  }

  void send_beside(const recording::RecordedFrame& frame) {
    const Time now = Time::clock::now();
    const bool changed = frame.calibration != calibration_ || begun_ != server_.begun();
    if (!changed && now < calibration_due_) {
      return;
    }
    calibration_ = frame.calibration;
    begun_ = server_.begun();
    calibration_due_ = now + kCalibrationPeriod;
    if (const auto packet = packets_->calibration(frame); !packet.empty()) {
      send_one(packet);
    }
  }

  void send_one(std::span<const std::byte> datagram) { server_.send(std::span(&datagram, 1)); }

  void send_paced(wire::Datagrams datagrams) {
    while (!datagrams.empty()) {
      const std::size_t count = std::min(kBurst, datagrams.size());
      server_.send(datagrams.first(count));
      datagrams = datagrams.subspan(count);
      serve_until(Time::clock::now() + kGap);
    }
  }

  const ReplayOptions& options_;
  recording::ReplayServer& server_;
  std::optional<recording::FrameReader> reader_;
  std::optional<recording::RecordedPackets> packets_;
  BesideQueue beside_;
  wire::Origin recorded_{};
  std::uint64_t first_log_time_ = 0;  // is played at began_
  std::uint64_t played_until_ = 0;    // log time
  Time began_;
  std::optional<wire::HealthReport> health_;  // the last one that was sent
  std::uint64_t health_log_time_ = 0;
  Time health_sent_;
  Time repeat_until_;
  Time calibration_due_;
  std::optional<wire::CalibrationPacket> calibration_;
  std::uint64_t begun_ = 0;  // subscriptions that have got it
  bool given_up_ = false;
  std::uint64_t frames_ = 0;
  std::uint64_t healths_ = 0;  // without repetitions
  std::uint64_t events_ = 0;
  std::uint64_t not_whole_ = 0;
  std::uint64_t passes_ = 0;
  std::uint64_t damaged_ = 0;
};

}  // namespace

void replay(const ReplayOptions& options) {
  stop_on_signals();
  if (!wire::start_crypto()) {
    throw Failure(Exit::kFailure, "this system has no random numbers");
  }
  // Before anybody waits for it.
  const recording::Summary summary = value_or_fail(recording::summarise(options.file));
  if (summary.frames == 0) {
    throw Failure(Exit::kBadInput, options.file.string() + ": holds no frames of a sensor");
  }
  if (summary.frames == summary.incomplete_frames) {
    throw Failure(Exit::kBadInput, options.file.string() +
                                       ": none of its frames was received as a whole, and no other "
                                       "is sent: stof view FILE shows them");
  }
  auto server = recording::ReplayServer::open(options.bind, options.port);
  if (!server) {
    throw Failure(Exit::kBadInput, server.error());
  }
  const std::string place = options.bind + ":" + std::to_string(server->port());
  if (!options.json) {
    say("replay of " + options.file.string() + ", " + std::to_string(summary.frames) +
        " frames: nothing of it is new; subscribe at " + place);
  }
  if (!options.port_file.empty()) {
    value_or_fail(dataset::write_whole(options.port_file, std::to_string(server->port()) + "\n"));
  }
  Player player(options, *server);
  do {
    player.play(value_or_fail(recording::FrameReader::open(options.file)));
  } while (options.loop && !player.over() && player.frames() != 0);
  if (options.json) {
    const nlohmann::ordered_json json{{"file", options.file.string()},
                                      {"frames", player.frames()},
                                      {"frames_not_whole", player.not_whole()},
                                      {"health", player.healths()},
                                      {"events", player.events()},
                                      {"passes", player.passes()},
                                      {"damaged", player.damaged()},
                                      {"subscriptions", server->begun()}};
    say_json(json);
  } else {
    std::printf("sent %llu frames to %llu subscriptions",
                static_cast<unsigned long long>(player.frames()),
                static_cast<unsigned long long>(server->begun()));
    std::printf(player.not_whole() == 0 ? "\n" : ", %llu not: they were not received as a whole\n",
                static_cast<unsigned long long>(player.not_whole()));
  }
  if (player.given_up()) {
    throw Failure(Exit::kFailure, "nobody subscribed: stof view " + place);
  }
  if (player.not_whole() != 0 || player.damaged() != 0) {
    throw Failure(Exit::kFailure,
                  "not all of the recording could be sent: " + std::to_string(player.not_whole()) +
                      " frames, " + std::to_string(player.damaged()) + " damaged records");
  }
}

void add_replay(CLI::App& app, ReplayOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "replay", "Send a recording to clients, as a sensor would: stof view and libstof subscribe");
  command.footer(
      "Example: stof replay hall.mcap --loop\n"
      "In another terminal: stof view 127.0.0.1\n"
      "It begins when the first client subscribes. Stamps and numbers are those of the recording, "
      "the session is a new one, and every packet says that its clock is that of a recording.\n"
      "To compute depth again of raw pictures: stofd --replay FILE.\n"
      "Ends with 0 (all of it was sent), 1 (not all of it could be, or nobody subscribed) or 2 "
      "(bad "
      "input, or the port cannot be had).");
  command.add_option("FILE", options.file, "The recording")->required();
  command.add_option("--rate", options.rate, "2: twice as fast as it was, 0.5: half")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  command.add_flag("--loop", options.loop, "From its begin again, until interrupted");
  command.add_option("--port", options.port, "UDP port to be subscribed at, 0: any free one")
      ->capture_default_str();
  command
      .add_option("--bind", options.bind,
                  "Address of the interface; 0.0.0.0: every client of the network may subscribe")
      ->capture_default_str();
  command.add_option("--port-file", options.port_file,
                     "File that gets the number of the opened port");
  command
      .add_option("--timeout", options.timeout_s,
                  "Give up after so many seconds without a subscriber; 0: wait until interrupted")
      ->check(CLI::Range(0.0, 1e7))
      ->capture_default_str();
  add_json_flag(command, options.json);
  command.callback([&options] { replay(options); });
}

}  // namespace stof::host

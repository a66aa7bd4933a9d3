#include "host/cli/sensor/check.h"

#include <algorithm>
#include <chrono>

#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/live/reception.h"
#include "host/cli/output.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor/sensor_info.h"
#include "host/cli/view/status_line.h"
#include "host/discovery/discover.h"
#include "host/recording/recording.h"

namespace stof::host {
namespace {

// What frames tell beside their figures.
void look_at(const client::Frame& frame, CheckFacts& facts) {
  facts.clock = frame.stamp.clock;
  if (!frame.info) {
    return;
  }
  facts.drift = drift_text(*frame.info);
  // While one is put in, the first frames may name it before it comes.
  facts.other_calibration = frame.calibration && frame.info->calibration_fingerprint != 0 &&
                            frame.calibration->fingerprint != 0 &&
                            frame.calibration->fingerprint != frame.info->calibration_fingerprint;
}

// What came of it, as soon as it is over: ages count from now.
void note_reception(Reception& reception, CheckFacts& facts) {
  const client::Receiver& receiver = reception.receiver();
  facts.all_places_taken = receiver.subscription() == client::Subscription::State::kFull;
  facts.stats.source = reception.place();
  facts.stats.device = reception.device();
  facts.stats.counts = receiver.statistics();
  const client::LinkState link = receiver.link();
  facts.comes = reception.frames() == 0 || link.silent ? what_comes(link) : Comes::kFrames;
  facts.silent_since = link.frame_age;
  facts.forged_traffic = link.forged_traffic;
  // One that goes on is no gap in the stream.
  const unsigned silences = reception.link().silences();
  facts.stats.silences = silences - (link.silent && silences != 0 ? 1U : 0U);
  facts.stats.restarts = reception.link().restarts();
  facts.calibration = receiver.calibration();
  if (receiver.health()) {
    facts.health = HealthState{
        .source = facts.stats.source, .report = *receiver.health(), .age = link.health_age};
  }
  facts.network = network_facts(receiver.fd());
  facts.buffer = receiver.socket_buffer();
  facts.asked_buffer = client::ReceiverOptions{}.socket_buffer;
}

bool beacon_is_heard(const CheckFacts& facts) {
  constexpr std::chrono::milliseconds kBeacons{1300};  // one comes once a second
  const auto near = client::discover({.timeout = kBeacons});
  const auto beacon = static_cast<std::size_t>(client::DiscoveryMethod::kBeacon);
  return near && facts.identity &&
         std::ranges::any_of(*near, [&](const client::FoundSensor& sensor) {
           return sensor.serial == facts.identity->serial && sensor.methods[beacon];
         });
}

void check(const CheckOptions& options) {
  const CheckFacts facts =
      is_recorded(options.sensor) ? check_file(options) : check_sensor(options);
  const std::vector<Check> checks = judge_checks(facts);
  if (options.json) {
    say_json(checks_json(options.sensor, checks));
  } else {
    say_text(checks_text(checks));
  }
  if (worst_of(checks) == CheckVerdict::kFix) {
    const auto count = std::ranges::count(checks, CheckVerdict::kFix, &Check::verdict);
    throw Failure(Exit::kFailure, options.sensor + ": " + std::to_string(count) + " of " +
                                      std::to_string(checks.size()) +
                                      " checks found what has to be mended");
  }
}

}  // namespace

CheckFacts check_sensor(const CheckOptions& options,
                        const std::function<void(const client::Frame&)>& look,
                        const std::function<void(const wire::EventReport&)>& event) {
  CheckFacts facts{.sensor = options.sensor, .version = options.version};
  const std::string address = sensor_address(options.sensor);
  facts.sending_refused = sending_is_refused(address);
  Reception reception(
      options,
      {.frame =
           [&](const client::Frame& frame) {
             facts.stats.figures.take(
                 frame,
                 std::chrono::duration<double>(frame.last_packet.time_since_epoch()).count());
             look_at(frame, facts);
             if (look) {
               look(frame);
             }
           },
       .event = event});
  client::Receiver& receiver = reception.receiver();
  const client::Time began = client::Time::clock::now();
  std::optional<client::Time> first;
  reception.run([&] {
    const client::Time now = client::Time::clock::now();
    facts.subscribed =
        facts.subscribed || receiver.subscription() == client::Subscription::State::kActive;
    facts.nobody_listens = facts.nobody_listens || receiver.take_refusal();
    if (!first && reception.frames() != 0) {
      first = now;
    }
    if (!first) {
      return now - began >= std::chrono::duration<double>(options.timeout_s);
    }
    // Health and calibration come once a second.
    const bool told = receiver.health() && receiver.calibration();
    const client::LinkState link = receiver.link();
    // Whether what is silent has ended takes a moment to tell.
    const bool undecided = link.silent && *link.frame_age < kSilenceThatLasts;
    return !undecided && now - *first >= std::chrono::duration<double>(
                                             options.seconds + (told ? 0 : options.timeout_s));
  });
  note_reception(reception, facts);
  if (facts.clock == wire::ClockState::kRecorded) {
    facts.no_identity = "a recording is played again, which does not say";
  } else if (auto identity =
                 ask_identity(options, facts.comes == Comes::kFrames, facts.stats.device)) {
    facts.identity = std::move(*identity);
  } else {
    facts.no_identity = identity.error();
  }
  facts.beacon_heard =
      !facts.network.loopback && facts.comes != Comes::kNothing && beacon_is_heard(facts);
  return facts;
}

CheckFacts check_file(const CheckOptions& options) {
  CheckFacts facts{.recorded = true,
                   .sensor = options.sensor,
                   .stats = stats_of_file(options.sensor, options.json)};
  auto reader = value_or_fail(recording::FrameReader::open(options.sensor));
  while (const std::optional<recording::RecordedFrame> frame = reader.next()) {
    facts.calibration = frame->calibration ? frame->calibration : facts.calibration;
    facts.frames_without_lens += frame->calibration ? 0U : 1U;
    look_at(frame->view(), facts);
  }
  facts.lenses_contradict = reader.lenses().contradict();
  facts.forged_traffic = reader.forged_traffic();
  if (!reader.sights().health.empty()) {
    facts.health = health_of_file(options.sensor, options.json);
  }
  return facts;
}

void add_check(CLI::App& app, CheckOptions& options, const char* version) {
  options.version = version;
  CLI::App& command = *app.add_subcommand(
      "check", "What is wrong between a sensor and this computer, and what to do about it");
  show_example(command, "stof check 192.168.1.20",
               "One line each, with what to do: reach, firewall, mtu, buffers, link, clock, "
               "calibration, health, key, version. A recording tells file, link, clock, "
               "calibration and health.\n"
               "Ends with 0 (nothing has to be mended), 1 (something has, or the output cannot be "
               "written) or 2 (bad input).");
  add_reading_flags(command, options, options.json);
  command.add_option("--seconds", options.seconds, "How long it listens, from the first frame")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  command.callback([&options, &command] {
    judge_reading_flags(command, options.sensor);
    check(options);
  });
}

}  // namespace stof::host

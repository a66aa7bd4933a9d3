#include "host/cli/recording/record.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <system_error>

#include <nlohmann/json.hpp>

#include "firmware/wire/frame/raw_packets.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/live/frame_wait.h"
#include "host/cli/live/link_teller.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/recording/sensor_documents.h"
#include "host/cli/sensor_text.h"
#include "host/cli/stop_signal.h"
#include "host/cli/view/raw_files.h"
#include "host/cli/view/status_line.h"
#include "host/client/printable.h"
#include "host/recording/recorder.h"
#include "host/recording/session_recording.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kMegabyte = 1e6;
// A sensor begins anew no more often than this, and what is asked for meanwhile waits.
constexpr double kAnewS = 8;

// One recording from the first frame to the last.
class Recording {
 public:
  Recording(const RecordOptions& options, client::Receiver& receiver, recording::Recorder& recorder,
            recording::SensorDocuments documents)
      : options_(options),
        receiver_(receiver),
        recorder_(recorder),
        session_(recorder,
                 {.program = options.program,
                  .sensor = name_for_file(options),
                  .is_signed = options.signed_streams,
                  .raw = options.raw,
                  .read = documents_reader(options)},
                 std::move(documents)) {}

  // Until enough came, a signal, the timeout, or a disk that takes no more.
  void run() {
    constexpr std::chrono::milliseconds kLook{100};
    const client::Time began = client::Time::clock::now();
    client::Time said = began;
    while (!asked_to_stop() && !enough() && !recorder_.failed()) {
      const Result<client::Frame> frame = receiver_.next(kLook);
      take_beside();  // it came before the frame was whole
      take(frame);
      take_raw();
      if (const std::string change =
              teller_.look(receiver_.link(), receiver_.health(), client::Time::clock::now());
          !change.empty()) {
        options_.json ? say_aside(change) : say(change);
      }
      const client::Time now = client::Time::clock::now();
      silent_ = frames_stay_away(receiver_, began, options_.timeout_s, now);
      if (silent_ || raw_stay_away(now)) {
        return;
      }
      if (frames() != 0 && now - said >= std::chrono::seconds(1)) {
        said = now;
        say(std::to_string(frames()) + " frames recorded" + raw_text() + dropped_text() +
            link_text(receiver_.link()));
      }
    }
  }

  // Settings that are still asked for, at the end.
  void finish() { session_.finish(); }

  std::uint64_t received() const { return received_; }  // frames
  std::uint64_t frames() const { return session_.frames(); }
  std::uint64_t exposures() const { return session_.exposures(); }
  std::uint64_t lost_pictures() const { return session_.lost_pictures(); }
  std::uint64_t dropped() const { return session_.dropped(); }
  // Exposures of which a camera gave nothing: they are recorded as they are.
  std::uint64_t without_a_camera() const { return without_a_camera_; }
  const LinkTeller& link() const { return teller_; }
  wire::ClockState clock() const { return clock_; }  // of the last frame
  // Less than was asked for.
  bool short_of() const {
    return silent_ || (options_.frames != 0 && counted() < options_.frames && !asked_to_stop());
  }
  void say(const std::string& line) const {
    if (!options_.json) {
      host::say(line);
    }
  }

 private:
  std::uint64_t counted() const { return options_.raw ? exposures() : frames(); }
  // Who is denied raw pictures is so for good; another one's end some time.
  bool raw_stay_away(client::Time now) const {
    return options_.raw && exposures() == 0 &&
           (receiver_.raw_refusal() == wire::SubscribeResult::kRawDenied ||
            (frames() != 0 &&
             now - began_ > std::chrono::duration<double>(std::max(options_.timeout_s, kAnewS))));
  }
  bool enough() const {
    if (counted() == 0) {
      return false;
    }
    const bool time_is_over =
        options_.seconds > 0 && client::Time::clock::now() - counting_since_ >=
                                    std::chrono::duration<double>(options_.seconds);
    return time_is_over || (options_.frames != 0 && counted() >= options_.frames);
  }

  std::string raw_text() const {
    return options_.raw ? ", " + std::to_string(exposures()) + " with raw pictures" : "";
  }

  std::string dropped_text() const {
    return dropped() == 0
               ? ""
               : ", " + std::to_string(dropped()) + " not: the disk is too slow for them";
  }

  void take(const Result<client::Frame>& frame) {
    if (!frame) {
      if (frame.error() == Status::kDeviceLost) {
        throw Failure(Exit::kFailure, "the socket failed: start again");
      }
      return;
    }
    if (frames() + dropped() == 0) {
      began_ = client::Time::clock::now();
      counting_since_ = began_;
      say(first_frame_line(options_, receiver_, frame->origin.device_id));
      say(streams_line(*frame));
      if (frame->stamp.clock == wire::ClockState::kRecorded) {
        say(kReplayLine);
      }
    }
    clock_ = frame->stamp.clock;
    ++received_;
    session_.take(*frame, receiver_.place());
  }

  // Raw pictures, from the exposure on that was computed from a known state.
  void take_raw() {
    while (const std::optional<client::RawExposure> exposure = receiver_.take_raw()) {
      if (session_.counts(*exposure) && exposures() == 0) {
        counting_since_ = client::Time::clock::now();
      }
      session_.take(*exposure);
      without_a_camera_ += session_.raw_begun() && lacks_a_camera(*exposure) ? 1U : 0U;
    }
  }

  // That it should have: the PMD camera may be slower than the edges.
  static bool lacks_a_camera(const client::RawExposure& exposure) {
    constexpr std::uint32_t kPair = wire::kRawLeft | wire::kRawRight;
    const std::uint32_t all = exposure.info.pmd_every > 1 ? kPair : kPair | wire::kRawPmd;
    return (exposure.info.pictures & all) != all;
  }

  // What the sensor says beside frames. Events that come before the first frame wait for it.
  void take_beside() {
    session_.look(receiver_);
    if (!session_.begun()) {
      return;
    }
    while (const std::optional<client::ToldEvent> event = receiver_.take_event()) {
      say(event_line(event->report));
      session_.take(*event);
    }
  }

  const RecordOptions& options_;
  client::Receiver& receiver_;
  LinkTeller teller_;
  recording::Recorder& recorder_;
  recording::SessionRecording session_;
  client::Time began_;
  client::Time counting_since_;
  std::uint64_t received_ = 0;
  std::uint64_t without_a_camera_ = 0;
  wire::ClockState clock_ = wire::ClockState::kMonotonic;
  bool silent_ = false;
};

void print_json(const RecordOptions& options, const Recording& session,
                const recording::Recorder::Ended& ended) {
  nlohmann::ordered_json json{{"file", options.file.string()},
                              {"frames", ended.frames},
                              {"frames_not_written", session.received() - ended.frames},
                              {"messages", ended.statistics.message_count},
                              {"bytes", ended.bytes},
                              {"whole", ended.indexed},
                              {"indexed", ended.indexed},
                              {"silences", session.link().silences()},
                              {"restarts", session.link().restarts()}};
  if (options.raw) {
    json["raw_exposures"] = session.exposures();
    json["raw_incomplete"] = session.lost_pictures();
    json["raw_without_a_camera"] = session.without_a_camera();
  }
  say_json(json);
}

std::string written_line(const RecordOptions& options, const Recording& session,
                         const recording::Recorder::Ended& ended) {
  const std::uint64_t left_out = session.received() - ended.frames;
  return printed("wrote %s: %llu frames, %llu messages, %.1f MB",
                 client::printable(options.file.string()).c_str(),
                 static_cast<unsigned long long>(ended.frames),
                 static_cast<unsigned long long>(ended.statistics.message_count),
                 static_cast<double>(ended.bytes) / kMegabyte) +
         (left_out == 0 ? ""
                        : printed("; %llu frames that came are not in it",
                                  static_cast<unsigned long long>(left_out)));
}

void judge(const RecordOptions& options, client::Receiver& receiver, const Recording& session,
           const recording::Recorder::Ended& ended) {
  const std::string place = place_of(receiver);
  if (ended.problem) {
    const char* const index = ended.indexed ? "" : ", without an index: stof recover FILE";
    const std::string left = "; the recording ended, what was written whole is there";
    throw Failure(Exit::kFailure,
                  ended.problem->message +
                      (ended.frames == 0 ? std::string("; no frame was kept") : left + index));
  }
  const wire::SubscribeResult refusal = receiver.raw_refusal();
  if (options.raw && session.exposures() == 0 &&
      (session.frames() != 0 || refusal != wire::SubscribeResult::kOk)) {
    throw Failure(Exit::kFailure,
                  place + ": no raw pictures came" +
                      (asked_to_stop() ? " before it was interrupted" : raw_absence(refusal)) +
                      "; nothing was kept");
  }
  if (session.frames() == 0) {
    throw Failure(Exit::kFailure, place + ": no frame came" + absence_text(receiver, options));
  }
  if (session.short_of()) {
    throw Failure(Exit::kFailure, place + ": the stream ended after " +
                                      std::to_string(session.frames()) + " frames" +
                                      ended_text(receiver, options, session.clock()));
  }
  if (options.raw) {
    const client::RawStatistics& raw = receiver.raw_statistics();
    if (raw.incomplete + raw.lost + raw.untaken + raw.dropped != 0) {
      throw Failure(Exit::kFailure, "not all raw pictures are in the recording (" + raw_line(raw) +
                                        "): the sensor or the link had no time for them, or a "
                                        "camera was opened again: a longer period, fewer streams "
                                        "or a faster link help against the first");
    }
  }
  if (session.dropped() != 0) {
    throw Failure(Exit::kFailure, std::to_string(session.dropped()) +
                                      " frames are not in the recording: the disk is too slow: "
                                      "record to another one, or fewer streams");
  }
}

// With raw pictures these have to be there: without them nothing can be computed again.
recording::SensorDocuments documents_of(const RecordOptions& options) {
  constexpr int kTries = 3;
  recording::SensorDocuments documents = read_documents(options, options.raw);
  const auto lacks = [&] {
    return options.raw && (documents.settings.empty() || documents.calibration.empty());
  };
  for (int i = 1; i < kTries && lacks() && !asked_to_stop(); ++i) {
    documents = read_documents(options, options.raw);
  }
  if (lacks()) {
    throw Failure(Exit::kFailure,
                  "--raw: " + (documents.settings.empty() ? documents.no_settings
                                                          : documents.no_calibration));
  }
  return documents;
}

// Where the disk takes nothing no file is left.
std::unique_ptr<recording::Recorder> recorder_of(mcap::FileSink& sink,
                                                 const RecordOptions& options) {
  auto recorder = recording::Recorder::start(sink, {.library = options.program});
  if (!recorder) {
    std::error_code none;
    std::filesystem::remove(options.file, none);
  }
  return value_or_fail(std::move(recorder));
}

// All that the cameras give, of each frame, from a state that begins anew.
wire::RawRequest raw_request(const RecordOptions& options) {
  return options.raw ? wire::RawRequest{.pictures = wire::kRawPictures | wire::kRawAnew}
                     : wire::RawRequest{};
}

}  // namespace

void record(const RecordOptions& options) {
  stop_on_signals();
  RecordOptions meant = options;
  auto sink = value_or_fail(
      mcap::FileSink::open(meant.file, meant.force ? mcap::FileSink::Existing::kReplace
                                                   : mcap::FileSink::Existing::kRefuse));
  auto recorder = recorder_of(sink, meant);
  // Ends the file; one that holds nothing of what was asked for goes again.
  const auto finish = [&] {
    recording::Recorder::Ended ended = recorder->finish();
    if ((meant.raw ? ended.exposures : ended.frames) == 0) {
      std::error_code none;
      std::filesystem::remove(meant.file, none);
      ended.frames = 0;
    }
    return ended;
  };
  try {
    client::Receiver receiver = open_receiver(meant, raw_request(meant));
    Recording session(meant, receiver, *recorder, documents_of(meant));
    session.say("recording " + place_of(receiver) + " to " + meant.file.string());
    tell_port(meant, receiver);
    session.run();
    session.finish();
    const recording::Recorder::Ended ended = finish();
    if (session.frames() != 0) {
      session.say(summary_line(receiver.statistics()));
    }
    if (ended.frames != 0) {
      if (session.without_a_camera() != 0) {
        session.say(std::to_string(session.without_a_camera()) +
                    " exposures lack what a camera did not give: they are recorded without it");
      }
      session.say(written_line(meant, session, ended));
    }
    if (meant.json && ended.frames != 0) {
      print_json(meant, session, ended);
    }
    judge(meant, receiver, session, ended);
  } catch (const Failure&) {
    finish();
    throw;
  }
}

void add_record(CLI::App& app, RecordOptions& options, const char* program) {
  options.program = program;
  CLI::App& command = *app.add_subcommand(
      "record", "Record what a sensor sends: an MCAP file, which ROS 2 tools and Foxglove open");
  command.footer(
      "Example: stof record 192.168.1.20 hall.mcap --seconds 30\n"
      "Ends with 0 (recorded), 1 (nothing or less than asked for came, or the disk is full or too "
      "slow: what was written is kept) or 2 (bad input, or FILE cannot be written).");
  command
      .add_option("SENSOR", options.sensor,
                  std::string(kSensorOnly) + "; '-': listen for a sensor that sends here")
      ->required()
      ->check(not_empty());
  command.add_option("FILE", options.file, "The recording, by custom NAME.mcap")->required();
  command.add_option("--frames", options.frames, "End after so many frames; 0: when interrupted")
      ->capture_default_str();
  command
      .add_option("--seconds", options.seconds,
                  "End so long after the first frame; 0: when interrupted")
      ->check(CLI::Range(0.0, 1e7))
      ->capture_default_str();
  command.add_flag("--raw", options.raw,
                   "What the cameras gave as well, bit for bit: stofd --replay FILE computes depth "
                   "of it again. --frames counts exposures that have it. A paired sensor gives it "
                   "to --signed alone");
  command.add_flag("--force", options.force, "Replace FILE where it is there");
  add_json_flag(command, options.json);
  add_receive_flags(command, options);
  command.callback([&options] {
    if (options.sensor == "-") {
      options.sensor.clear();
    }
    judge_receive_options(options);
    if (options.file == "-") {
      throw Failure(Exit::kBadInput,
                    "FILE -: a recording is not written to stdout: give the name of a file, ./- "
                    "for one that is called so");
    }
    if (options.raw && options.sensor.empty()) {
      throw Failure(Exit::kBadInput, "--raw: takes a SENSOR to subscribe at");
    }
    record(options);
  });
}

}  // namespace stof::host

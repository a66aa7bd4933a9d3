#include "host/cli/view/page_view.h"

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "firmware/wire/messages/conditions.h"
#include "host/cli/failure.h"
#include "host/cli/live/robot_state.h"
#include "host/cli/own_keys.h"
#include "host/cli/rig/calib_rig.h"
#include "host/cli/sensor_text.h"
#include "host/cli/view/status_line.h"
#include "host/viewer/browser.h"

namespace stof::host {

void add_page_flags(CLI::App& command, PageOptions& options) {
  command.add_option("--http-port", options.http_port,
                     "TCP port of the page in the browser, 0: any free one (default: 7570, or any "
                     "free one)");
  command.add_flag("--lan", options.lan,
                   "Others on the network may open the page, by an address with a token: whoever "
                   "has the address sees what the sensor sees");
  command.add_flag("--lan-control", options.lan_control,
                   "With --lan: whoever has the address may also change settings, record, "
                   "calibrate and put releases of --update-from on the sensor, with your keys of "
                   "it, but not pair");
  command
      .add_option("--record-to", options.record_to,
                  "Folder of what the page leaves: recordings, and calibrations")
      ->capture_default_str();
  command.add_option("--update-from", options.update_from,
                     "Folder of releases (*.update): the page may put one of them on the sensor, "
                     "with your key of role admin");
  command.add_option("--fault-socket", options.fault_socket,
                     "Of an emulated sensor, as stofd has it: the page can make it fail");
  command.add_option("--foxglove-origin", options.foxglove_origins,
                     "Where Foxglove or Lichtblick that may connect runs in a browser, such as "
                     "https://app.foxglove.dev; also file:// of a desktop program");
  command.add_flag("--no-browser", options.no_browser, "Print the page's address, open no browser");
}

namespace {

// Throws Failure.
void judge_origins(const PageOptions& options) {
  for (const std::string& origin : options.foxglove_origins) {
    // As a browser sends it: "null" would be any page that hides where it is from.
    const std::size_t colon = origin.find("://");
    const bool file = origin == "file://";
    if (!file && (colon == 0 || colon == std::string::npos || colon + 3 == origin.size() ||
                  origin.find('/', colon + 3) != std::string::npos)) {
      throw Failure(Exit::kBadInput,
                    "--foxglove-origin: " + origin +
                        ": is no origin: give https://app.foxglove.dev, or file://");
    }
  }
}

// Throws Failure. Nobody who did not name it needs the current folder.
void judge_record_to(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    throw Failure(Exit::kBadInput, "--record-to: " + folder.string() +
                                       ": is no folder: make it, or give another one");
  }
  if (folder != "." && access(folder.c_str(), W_OK | X_OK) != 0) {
    throw Failure(Exit::kBadInput, "--record-to: " + folder.string() + ": cannot be written (" +
                                       std::generic_category().message(errno) +
                                       "): give another folder");
  }
}

// Throws Failure. live: of a sensor.
void judge(const PageOptions& options, bool live) {
  if (options.lan_control && !options.lan) {
    throw Failure(Exit::kBadInput,
                  "--lan-control: goes with --lan: without it no other machine "
                  "opens the page");
  }
  judge_origins(options);
  std::error_code error;
  if (live) {
    judge_record_to(options.record_to);
  }
  if (!options.update_from.empty() && !std::filesystem::is_directory(options.update_from, error)) {
    throw Failure(Exit::kBadInput, "--update-from: " + options.update_from.string() +
                                       ": is no folder: name the one that holds the releases");
  }
}

}  // namespace

void PageView::open(const PageOptions& options, const ReceiveOptions& receive,
                    viewer::ViewerOptions shown) {
  judge(options, !shown.recording);
  receive_ = &receive;
  DeskOptions desk{.fault_socket = options.fault_socket,
                   .calibrate_in = options.record_to,
                   .calibration_absence = has_calib_rig() ? "" : kRigAbsence,
                   .update_from = options.update_from,
                   .sensor = !shown.recording};
  desk.config.keys = keys_file(receive.keys);
  desk.config.device = receive.device;
  desk.config.key = receive.key;
  desk_ = std::make_unique<PageDesk>(std::move(desk));
  desk_->know({.address = receive.sensor});
  if (!shown.recording) {
    recording_ = std::make_unique<PageRecording>(options.record_to, options.program);
  }
  shown.serve = [raw = desk_.get()](const viewer::Page& page, viewer::Wish wish,
                                    viewer::Answer answer) {
    raw->serve(page, std::move(wish), std::move(answer));
  };
  shown.lan_control = options.lan_control;
  shown.foxglove_origins = options.foxglove_origins;
  shown.lan = options.lan;
  shown.port = options.http_port;
  std::expected<viewer::Viewer, std::string> viewer = viewer::Viewer::open(shown);
  if (!viewer) {
    throw Failure(Exit::kBadInput, viewer.error());
  }
  viewer_.emplace(std::move(*viewer));
  desk_->tell_by(
      [this](viewer::Topic topic, std::string json) { viewer_->tell(topic, std::move(json)); });
  viewer_->tell(
      viewer::Topic::kRecording,
      viewer::recording_message(recording_ ? recording_->state() : viewer::RecordingState{}));
  const std::vector<std::string> addresses = viewer_->addresses();
  for (const std::string& address : addresses) {
    std::printf("page: %s\n", address.c_str());
  }
  if (!viewer::Viewer::has_page()) {
    std::puts(
        "the page is not in this build: install esbuild (scripts/setup does), configure anew "
        "(cmake --preset emu --fresh) and build again");
  }
  std::fflush(stdout);
  if (!options.no_browser && isatty(STDOUT_FILENO) != 0) {
    viewer::open_browser(addresses.front());
  }
}

PageView::~PageView() {
  if (desk_) {
    desk_->tell_by({});  // the viewer goes first
  }
}

void PageView::show(const client::Frame& frame, const bridge::RobotFeed::Times& times) {
  if (viewer_) {
    device_ = frame.origin.device_id;
    device_known_ = true;
    viewer_->show(frame, latency_ms(frame), times);
  }
}

void PageView::record(const client::Frame& frame, client::Receiver& receiver) {
  if (recording_) {
    recording_->look(receiver);
    recording_->take(frame, receiver.place());
  }
}

void PageView::record(const client::ToldEvent& event) {
  if (recording_) {
    recording_->take(event);
  }
}

void PageView::tell(const wire::EventReport& event, const std::string& text,
                    std::optional<std::uint64_t> at_ms) {
  if (viewer_) {
    viewer_->tell(event, text, at_ms);
  }
}

void PageView::tell(const LinkTeller::Change& change, std::optional<std::uint64_t> at_ms) {
  if (viewer_) {
    viewer_->tell(
        viewer::LinkEvent{
            .text = change.text, .severity = change.severity, .active = change.active},
        at_ms);
  }
}

bool PageView::due(client::Time now) {
  constexpr std::chrono::milliseconds kEvery{500};
  if (!visited() || now - told_ < kEvery) {
    return false;
  }
  told_ = now;
  return true;
}

// Where the sensor that is received is asked for something.
ReceiveOptions PageView::asked(const client::Receiver& receiver) const {
  ReceiveOptions asked = *receive_;
  if (asked.sensor.empty()) {
    asked.sensor = receiver.sender();
  }
  return asked;
}

void PageView::serve_own(const client::Receiver& receiver) {
  while (const std::optional<PageDesk::Own> own = desk_->take_own()) {
    const auto& [wish, answer] = *own;
    if (const auto* const recording = std::get_if<viewer::SetRecording>(&wish)) {
      std::expected<void, std::string> done;
      if (recording->on) {
        done = recording_->begin(asked(receiver));
      } else {
        recording_->end();
      }
      viewer_->tell(viewer::Topic::kRecording, viewer::recording_message(recording_->state()));
      answer(done.has_value(), done ? std::string() : done.error());
    } else {
      answer(false, "a live sensor cannot be wound back: record it");
    }
  }
}

void PageView::look(const ReceiveOptions& options, client::Receiver& receiver, client::Time now) {
  if (!viewer_) {
    return;
  }
  serve_own(receiver);
  recording_->look(receiver);
  if (due(now)) {
    tell_status(options, receiver);
    viewer_->tell(viewer::Topic::kRecording, viewer::recording_message(recording_->state()));
    const std::uint32_t active = receiver.health() ? receiver.health()->active : 0;
    desk_->know({.address = asked(receiver).sensor,
                 .device = device_,
                 .unpaired = ((active >> static_cast<int>(wire::Condition::kUnpaired)) & 1U) != 0,
                 .told = receiver.health().has_value() && device_known_});
    desk_->look_at_faults();
    desk_->look_at_keys();
  }
}

void PageView::tell_status(const ReceiveOptions& options, client::Receiver& receiver) {
  const client::LinkState link = receiver.link();
  const std::string waiting =
      link.silent ? "no frame comes" + silence_text(receiver, options.device) : "";
  viewer_->tell({.statistics = receiver.statistics(),
                 .link = link,
                 .health = receiver.health(),
                 .health_text = receiver.health() ? health_line(*receiver.health()) : "",
                 .waiting = waiting});
  viewer_->tell(link_of(receiver, waiting));
}

bool PageView::tell_recorded(const client::Statistics& statistics,
                             const std::optional<wire::HealthReport>& health,
                             const std::string& waiting, client::Time now) {
  if (!due(now)) {
    return false;
  }
  const client::LinkState link{.silent = !waiting.empty()};
  viewer_->tell({.statistics = statistics,
                 .link = link,
                 .health = health,
                 .health_text = health ? health_line(*health) : "",
                 .waiting = waiting});
  viewer_->tell(bridge::RobotFeed::Link{
      .place = receive_->sensor, .health = health, .statistics = statistics, .recording = true});
  return true;
}

void PageView::tell(const viewer::PlaybackState& playback) {
  if (viewer_) {
    viewer_->tell(viewer::Topic::kPlayback, viewer::playback_message(playback));
  }
}

}  // namespace stof::host

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/live/link_teller.h"
#include "host/cli/receive.h"
#include "host/cli/view/page_desk.h"
#include "host/cli/view/page_recording.h"
#include "host/viewer/viewer.h"

namespace stof::host {

struct PageOptions {
  std::optional<std::uint16_t> http_port;  // none: the usual one, or any free one
  bool lan = false;                        // others on the network may look, with a token
  bool lan_control = false;  // and change what the page of this machine may, but not pair
  bool no_browser = false;
  std::filesystem::path record_to = ".";      // folder of what the page records
  std::filesystem::path update_from;          // folder of releases; empty: the page puts none
  std::string fault_socket;                   // of an emulated sensor; empty: none
  std::vector<std::string> foxglove_origins;  // see viewer::ViewerOptions
  std::string program;                        // name and version, for recordings
};

void add_page_flags(CLI::App& command, PageOptions& options);

// The page of `stof view` in the browser, or none. For the receiver's thread.
class PageView {
 public:
  PageView() = default;
  ~PageView();
  PageView(const PageView&) = delete;
  PageView& operator=(const PageView&) = delete;
  // Serves it, prints its addresses and opens the browser where the user sits at a terminal. Throws
  // Failure. shown: what and how; its port and `lan` are those of `options`. receive: of a sensor,
  // with its keys; outlives it.
  void open(const PageOptions& options, const ReceiveOptions& receive, viewer::ViewerOptions shown);

  // times: when it came.
  void show(const client::Frame& frame, const bridge::RobotFeed::Times& times);
  void record(const client::ToldEvent& event);
  // at_ms: of a recording, when it was recorded (Unix); none: now.
  void tell(const wire::EventReport& event, const std::string& text,
            std::optional<std::uint64_t> at_ms = std::nullopt);
  void tell(const LinkTeller::Change& change, std::optional<std::uint64_t> at_ms = std::nullopt);
  // Of a sensor, all of it behind each look at the receiver: what is recorded, what the page wants
  // done, and twice a second how things are.
  void look(const ReceiveOptions& options, client::Receiver& receiver, client::Time now);
  void record(const client::Frame& frame, client::Receiver& receiver);
  // Of a recording, twice a second: how things are. waiting: why no frame is shown; empty: they
  // are. False: it was not time.
  bool tell_recorded(const client::Statistics& statistics,
                     const std::optional<wire::HealthReport>& health, const std::string& waiting,
                     client::Time now);
  // The next one that is told waits for nothing.
  void tell_at_once() { told_ = {}; }
  void tell(const viewer::PlaybackState& playback);
  std::optional<PageDesk::Own> take_own() { return desk_ ? desk_->take_own() : std::nullopt; }
  // Somebody looks, or has: what is silent may come back.
  bool visited() const { return viewer_ && viewer_->visited(); }

 private:
  // A status; the next one half a second later.
  bool due(client::Time now);
  void serve_own(const client::Receiver& receiver);
  void tell_status(const ReceiveOptions& options, client::Receiver& receiver);
  ReceiveOptions asked(const client::Receiver& receiver) const;

  const ReceiveOptions* receive_ = nullptr;
  std::unique_ptr<PageDesk> desk_;            // it tells the viewer, whose server asks it
  std::unique_ptr<PageRecording> recording_;  // of a sensor
  std::optional<viewer::Viewer> viewer_;
  std::uint32_t device_ = 0;  // of the newest frame
  bool device_known_ = false;
  client::Time told_;
};

}  // namespace stof::host

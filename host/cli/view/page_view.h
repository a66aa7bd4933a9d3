#pragma once

#include <cstdint>
#include <optional>

#include <CLI/CLI.hpp>

#include "host/cli/receive.h"
#include "host/viewer/viewer.h"

namespace stof::host {

struct PageOptions {
  std::optional<std::uint16_t> http_port;  // none: the usual one, or any free one
  bool lan = false;                        // others on the network may look, with a token
  bool no_browser = false;
};

void add_page_flags(CLI::App& command, PageOptions& options);

// The page of `stof view` in the browser, or none.
class PageView {
 public:
  PageView() = default;
  // Serves it, prints its addresses and opens the browser where the user sits at a terminal. Throws
  // Failure. shown: what and how; its port and `lan` are those of `options`.
  void open(const PageOptions& options, viewer::ViewerOptions shown);

  void show(const client::Frame& frame);
  void tell(const wire::EventReport& event, const std::string& text);
  // Twice a second, whatever the receiver has.
  void tell_status(const ReceiveOptions& options, client::Receiver& receiver, client::Time now);
  // The same of a recording.
  void tell_recorded(const client::Statistics& statistics,
                     const std::optional<wire::HealthReport>& health, client::Time now);
  // Somebody looks, or has: what is silent may come back.
  bool visited() const { return viewer_ && viewer_->visited(); }

 private:
  // A status; the next one half a second later.
  bool due(client::Time now);

  std::optional<viewer::Viewer> viewer_;
  client::Time told_;
};

}  // namespace stof::host

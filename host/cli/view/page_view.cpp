#include "host/cli/view/page_view.h"

#include <cstdio>

#include <unistd.h>

#include "host/cli/failure.h"
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
  command.add_flag("--no-browser", options.no_browser, "Print the page's address, open no browser");
}

void PageView::open(const PageOptions& options, viewer::ViewerOptions shown) {
  shown.lan = options.lan;
  shown.port = options.http_port;
  std::expected<viewer::Viewer, std::string> viewer = viewer::Viewer::open(shown);
  if (!viewer) {
    throw Failure(Exit::kBadInput, viewer.error());
  }
  viewer_.emplace(std::move(*viewer));
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

void PageView::show(const client::Frame& frame) {
  if (viewer_) {
    viewer_->show(frame, latency_ms(frame));
  }
}

void PageView::tell(const wire::EventReport& event, const std::string& text) {
  if (viewer_) {
    viewer_->tell(event, text);
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

void PageView::tell_status(const ReceiveOptions& options, client::Receiver& receiver,
                           client::Time now) {
  if (!due(now)) {
    return;
  }
  const client::LinkState link = receiver.link();
  viewer_->tell(
      {.statistics = receiver.statistics(),
       .link = link,
       .health = receiver.health(),
       .health_text = receiver.health() ? health_line(*receiver.health()) : "",
       .waiting = link.silent ? "no frame comes" + silence_text(receiver, options.device) : ""});
}

void PageView::tell_recorded(const client::Statistics& statistics,
                             const std::optional<wire::HealthReport>& health, client::Time now) {
  if (due(now)) {
    const client::LinkState link{.silent = false};
    viewer_->tell({.statistics = statistics,
                   .link = link,
                   .health = health,
                   .health_text = health ? health_line(*health) : "",
                   .waiting = ""});
  }
}

}  // namespace stof::host

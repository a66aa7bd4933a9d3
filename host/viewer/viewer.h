#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bridge/robot_feed.h"
#include "host/viewer/broadcast.h"
#include "host/viewer/requests.h"
#include "host/viewer/status_message.h"

namespace stof::viewer {

struct ViewerOptions {
  std::string sensor{};       // what the page calls it
  host::ColourScale scale{};  // the page's fixed one
  bool recording = false;     // a file: what is shown happened before
  // Others than this machine may look; every address then carries a token.
  bool lan = false;
  bool lan_control = false;             // and have done what the page of this machine may, but pair
  std::optional<std::uint16_t> port{};  // none: kDefaultPort, or any free one where it is taken
  Serve serve{};                        // does what pages want; none: nothing
  // "https://app.foxglove.dev": where Foxglove or Lichtblick that may look runs in a browser.
  std::vector<std::string> foxglove_origins{};
};

// The page in the browser: its server and what it is shown. For one thread, the receiver's, unless
// said otherwise.
class Viewer {
 public:
  static constexpr std::uint16_t kDefaultPort = 7570;

  // One line where the port cannot be had.
  static std::expected<Viewer, std::string> open(const ViewerOptions& options);
  Viewer(Viewer&&) noexcept;
  Viewer& operator=(Viewer&&) noexcept;
  ~Viewer();

  // What to open, the best one first: of this machine, then (`lan`) of each of its networks. With
  // the token: for the user's eyes alone.
  std::vector<std::string> addresses() const;
  // Somebody has opened the page, or connected by Foxglove's protocol.
  bool visited() const noexcept;
  // False: this build has no page, but one that says how to build it.
  static bool has_page() noexcept;

  // A frame is copied where a page waits for one, or may yet ask for it, as it halts (of a
  // recording), and made into messages where a client of Foxglove's protocol subscribed to them;
  // the newest wins. times: when it came.
  void show(const client::Frame& frame, std::optional<double> latency_ms,
            const bridge::RobotFeed::Times& times);
  void tell(const Status& status);
  // The state as diagnostics, to clients of Foxglove's protocol.
  void tell(const bridge::RobotFeed::Link& link);
  // at_ms: when it was heard of (Unix); none: now.
  void tell(const wire::EventReport& event, const std::string& text,
            std::optional<std::uint64_t> at_ms = std::nullopt);
  void tell(const LinkEvent& event, std::optional<std::uint64_t> at_ms = std::nullopt);
  // For any thread.
  void tell(Topic topic, std::string json);

 private:
  struct Parts;
  explicit Viewer(std::unique_ptr<Parts> parts) noexcept;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stof::viewer

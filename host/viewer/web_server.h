#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/viewer/conversation.h"
#include "host/viewer/page_rights.h"
#include "host/viewer/web_access.h"

namespace stof::viewer {

// Who has connected.
struct WebVisitor {
  PageRight change = PageRight::kNoPage;  // whether it may have something done (page_rights.h)
  PageRight pair = PageRight::kNoPage;
  std::string place{};
};

// What is spoken over a WebSocket.
struct Subprotocol {
  std::string_view name{};  // ends with a 0; outlives the server
  bool foxglove = false;    // see AccessRules::foxglove_origins
  // Somebody has connected who speaks it. Called by the server's thread.
  std::function<std::unique_ptr<Conversation>(const WebVisitor& visitor)> open_conversation{};
};

struct WebServerOptions {
  std::string_view page{};                  // HTML; outlives the server
  std::string_view policy{};                // its Content-Security-Policy; outlives the server
  std::vector<Subprotocol> subprotocols{};  // a client that offers more of them gets its first
  AccessRules rules{};
  bool every_interface = false;  // false: loopback alone
  std::uint16_t port = 0;        // 0: any free one
  bool or_any_port = false;      // where that one is taken
  std::size_t max_pages = 8;     // connected at a time; the next is refused (503)
};

// Serves one page over HTTP and talks with it over a WebSocket, in a thread of its own, by
// libwebsockets. GET / is the page, everything else is 404, other methods are 405; what the rules
// refuse is 403, one line says why. Requests carry no body, messages at most kMaxPageMessage bytes.
// A page that takes nothing for 10 s is disconnected.
class WebServer {
 public:
  // One line where the port cannot be had.
  static std::expected<WebServer, std::string> open(WebServerOptions options);
  WebServer(WebServer&&) noexcept;
  WebServer& operator=(WebServer&&) noexcept;
  ~WebServer();

  std::uint16_t port() const noexcept;
  // Conversations may have something new to say. For any thread.
  void wake() noexcept;

 private:
  struct Parts;
  explicit WebServer(std::unique_ptr<Parts> parts) noexcept;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stof::viewer

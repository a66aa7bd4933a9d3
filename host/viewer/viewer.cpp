#include "host/viewer/viewer.h"

#include <array>
#include <cstring>
#include <utility>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <unistd.h>

#include "host/viewer/broadcast.h"
#include "host/viewer/page_source.h"
#include "host/viewer/web_server.h"

namespace stof::viewer {
namespace {

std::string own_host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

// Of the interfaces that are up, but loopback ones.
std::vector<std::string> own_addresses() {
  std::vector<std::string> all;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) {
    return all;
  }
  for (const ifaddrs* at = first; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET ||
        (at->ifa_flags & IFF_UP) == 0 || (at->ifa_flags & IFF_LOOPBACK) != 0) {
      continue;
    }
    sockaddr_in address{};
    std::memcpy(&address, at->ifa_addr, sizeof address);
    std::array<char, INET_ADDRSTRLEN> text{};
    if (inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size()) != nullptr) {
      all.emplace_back(text.data());
    }
  }
  freeifaddrs(first);
  return all;
}

}  // namespace

struct Viewer::Parts {
  Broadcast broadcast;
  std::string token;
  bool lan;
  std::optional<WebServer> server{};  // last: its thread uses the others
};

Viewer::Viewer(std::unique_ptr<Parts> parts) noexcept : parts_(std::move(parts)) {}
Viewer::Viewer(Viewer&&) noexcept = default;
Viewer& Viewer::operator=(Viewer&&) noexcept = default;
Viewer::~Viewer() = default;

std::expected<Viewer, std::string> Viewer::open(const ViewerOptions& options) {
  std::unique_ptr<Parts> parts(new Parts{
      .broadcast =
          Broadcast(hello_message(options.sensor, options.scale, options.recording)),  // NOLINT
      .token = options.lan ? random_token() : "",
      .lan = options.lan});
  std::expected<WebServer, std::string> server = WebServer::open(
      {.page = kPage,
       .policy = kPagePolicy,
       .rules = {.host_name = own_host_name(), .token = parts->token, .any_address = options.lan},
       .every_interface = options.lan,
       .port = options.port.value_or(kDefaultPort),
       .or_any_port = !options.port,
       .open_conversation = [all = &parts->broadcast] { return all->open_conversation(); }});
  if (!server) {
    return std::unexpected(server.error());
  }
  parts->server.emplace(std::move(*server));
  return Viewer(std::move(parts));
}

std::vector<std::string> Viewer::addresses() const {
  std::string end = ":" + std::to_string(parts_->server->port()) + "/";
  if (!parts_->token.empty()) {
    end += "?token=" + parts_->token;
  }
  std::vector<std::string> all{"http://127.0.0.1" + end};
  for (const std::string& address : parts_->lan ? own_addresses() : std::vector<std::string>()) {
    all.push_back(std::string("http://").append(address).append(end));
  }
  return all;
}

bool Viewer::visited() const noexcept { return parts_->broadcast.visited(); }

bool Viewer::has_page() noexcept { return kHasPage; }

void Viewer::show(const client::Frame& frame, std::optional<double> latency_ms) {
  if (parts_->broadcast.wanted()) {
    parts_->broadcast.show(copy_of(frame, latency_ms));
    parts_->server->wake();
  }
}

void Viewer::tell(const Status& status) {
  if (visited()) {
    parts_->broadcast.tell_status(status_message(status));
    parts_->server->wake();
  }
}

void Viewer::tell(const wire::EventReport& event, const std::string& text) {
  parts_->broadcast.tell_event(event_message(event, text));
  parts_->server->wake();
}

}  // namespace stof::viewer

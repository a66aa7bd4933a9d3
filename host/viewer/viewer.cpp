#include "host/viewer/viewer.h"

#include <array>
#include <chrono>
#include <mutex>
#include <utility>

#include <net/if.h>
#include <unistd.h>

#include "host/viewer/broadcast.h"
#include "host/viewer/foxglove/foxglove_channels.h"
#include "host/viewer/foxglove/foxglove_message.h"
#include "host/viewer/page_source.h"
#include "host/viewer/web_server.h"
#include "posix/interfaces.h"

namespace stof::viewer {
namespace {

std::string own_host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

// Of the interfaces that are up, but loopback ones.
std::vector<std::string> own_addresses() {
  std::vector<std::string> all;
  for (const posix::InterfaceEntry& entry : posix::interface_entries()) {
    if (entry.address && entry.address->family() == AF_INET &&
        (entry.flags & (IFF_UP | IFF_LOOPBACK)) == IFF_UP) {
      all.push_back(entry.address->host());
    }
  }
  return all;
}

std::int64_t wall_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::uint64_t wall_ms() { return static_cast<std::uint64_t>(wall_ns() / 1'000'000); }

}  // namespace

// Answers come from any thread, also when the server is not there yet, or not any more.
class Wake {
 public:
  void pages() {
    const std::scoped_lock lock(mutex_);
    if (server_ != nullptr) {
      server_->wake();
    }
  }
  void set(WebServer* server) {
    const std::scoped_lock lock(mutex_);
    server_ = server;
  }

 private:
  std::mutex mutex_;
  WebServer* server_ = nullptr;
};

struct Viewer::Parts {
  std::shared_ptr<Wake> wake;
  std::string token;
  bool lan;
  bool recording;
  std::optional<Broadcast> broadcast{};
  std::optional<FoxgloveChannels> foxglove{};
  std::optional<bridge::RobotFeed> robot{};  // of the receiver's thread; publishes to them
  std::optional<WebServer> server{};         // last: its thread uses the others

  ~Parts() { wake->set(nullptr); }
};

Viewer::Viewer(std::unique_ptr<Parts> parts) noexcept : parts_(std::move(parts)) {}
Viewer::Viewer(Viewer&&) noexcept = default;
Viewer& Viewer::operator=(Viewer&&) noexcept = default;
Viewer::~Viewer() = default;

std::expected<Viewer, std::string> Viewer::open(const ViewerOptions& options) {
  std::unique_ptr<Parts> parts(new Parts{.wake = std::make_shared<Wake>(),
                                         .token = options.lan ? random_token() : "",
                                         .lan = options.lan,
                                         .recording = options.recording});
  // A frame of a recording is as new as it was.
  const Broadcast::Clock::duration most_age =
      options.recording ? std::chrono::hours(1000) : Broadcast::kMostAge;
  parts->broadcast.emplace(hello_message(options.sensor, options.scale, options.recording),
                           most_age, options.serve, [wake = parts->wake] { wake->pages(); });
  parts->foxglove.emplace("stof " + options.sensor, most_age,
                          [wake = parts->wake] { wake->pages(); });
  parts->robot.emplace(*parts->foxglove, bridge::FeedOptions{});
  parts->robot->place_frames(wall_ns());
  std::vector<Subprotocol> subprotocols{
      {.name = "stof.view.v1",
       .open_conversation = [all = &*parts->broadcast](const WebVisitor& who) {
         return all->open_conversation({.why_not = reason(who.change),
                                        .why_not_pair = pairing_reason(who.pair),
                                        .place = who.place});
       }}};
  for (const std::string_view name : kFoxgloveSubprotocols) {
    subprotocols.push_back({.name = name,
                            .foxglove = true,
                            .open_conversation = [all = &*parts->foxglove](const WebVisitor&) {
                              return all->open_conversation();
                            }});
  }
  std::expected<WebServer, std::string> server =
      WebServer::open({.page = kPage,
                       .policy = kPagePolicy,
                       .subprotocols = std::move(subprotocols),
                       .rules = {.host_name = own_host_name(),
                                 .token = parts->token,
                                 .lan_control = options.lan && options.lan_control,
                                 .any_address = options.lan,
                                 .foxglove_origins = options.foxglove_origins},
                       .every_interface = options.lan,
                       .port = options.port.value_or(kDefaultPort),
                       .or_any_port = !options.port});
  if (!server) {
    return std::unexpected(server.error());
  }
  parts->server.emplace(std::move(*server));
  parts->wake->set(&*parts->server);
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

bool Viewer::visited() const noexcept {
  return parts_->broadcast->visited() || parts_->foxglove->visited();
}

bool Viewer::has_page() noexcept { return kHasPage; }

void Viewer::show(const client::Frame& frame, std::optional<double> latency_ms,
                  const bridge::RobotFeed::Times& times) {
  parts_->robot->show(frame, times);
  if (parts_->broadcast->wanted() || parts_->recording) {
    parts_->broadcast->show(copy_of(frame, latency_ms));
    parts_->wake->pages();
  }
}

void Viewer::tell(const Status& status) {
  if (parts_->broadcast->visited()) {
    tell(Topic::kStatus, status_message(status));
  }
}

void Viewer::tell(const bridge::RobotFeed::Link& link) {
  if (parts_->foxglove->visited()) {
    parts_->robot->tell(link, wall_ns());
  }
}

void Viewer::tell(const wire::EventReport& event, const std::string& text,
                  std::optional<std::uint64_t> at_ms) {
  parts_->broadcast->tell_event(event_message(event, text, at_ms.value_or(wall_ms())));
  parts_->wake->pages();
}

void Viewer::tell(const LinkEvent& event, std::optional<std::uint64_t> at_ms) {
  parts_->broadcast->tell_event(event_message(event, at_ms.value_or(wall_ms())));
  parts_->wake->pages();
}

void Viewer::tell(Topic topic, std::string json) {
  parts_->broadcast->tell(topic, std::move(json));
  parts_->wake->pages();
}

}  // namespace stof::viewer

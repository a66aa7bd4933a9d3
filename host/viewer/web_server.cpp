#include "host/viewer/web_server.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <mutex>
#include <ranges>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include <libwebsockets.h>
#include <unistd.h>

#include "host/viewer/connection_guard.h"
#include "posix/fd.h"

namespace stof::viewer {
namespace {

constexpr int kStalledSeconds = 10;
constexpr int kRequestSeconds = 4;  // that a request may take to come
constexpr std::size_t kMostHeaderBytes = 2048;
// Beside the connections: what libwebsockets has for itself.
constexpr std::size_t kSpareDescriptors = 8;
constexpr std::size_t kMostWaiting = 64;        // connections that are no WebSocket
constexpr std::size_t kHugePacket = 64U << 20;  // a frame is given to the socket at once

// One connection. libwebsockets keeps the pointer.
struct Connection {
  std::unique_ptr<Conversation> conversation{};  // none: plain HTTP
  std::string message{};                         // of the page, as far as it has come
};

struct Slot {  // zeroed by libwebsockets
  Connection* connection;
};

// A header, or an argument of the address; empty where it is absent or too long.
std::string header(lws* wsi, lws_token_indexes token) {
  std::string text(kMostHeaderBytes, '\0');
  const int size = lws_hdr_copy(wsi, text.data(), static_cast<int>(text.size()), token);
  text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return text;
}

std::string token_of(lws* wsi) {
  constexpr std::string_view kName = "token=";
  std::array<char, 128> text{};
  for (int i = 0; lws_hdr_copy_fragment(wsi, text.data(), static_cast<int>(text.size()),
                                        WSI_TOKEN_HTTP_URI_ARGS, i) >= 0;
       ++i) {
    if (const std::string_view argument = text.data(); argument.starts_with(kName)) {
      return std::string(argument.substr(kName.size()));
    }
  }
  return {};
}

// libwebsockets ignores SIGPIPE for the whole program, which ends it at the end of a pipe.
class KeptSigpipe {
 public:
  KeptSigpipe() { sigaction(SIGPIPE, nullptr, &before_); }
  ~KeptSigpipe() { sigaction(SIGPIPE, &before_, nullptr); }
  KeptSigpipe(const KeptSigpipe&) = delete;
  KeptSigpipe& operator=(const KeptSigpipe&) = delete;

 private:
  struct sigaction before_{};
};

// A thread that no signal disturbs: they are the program's other threads'.
template <typename Body>
std::thread without_signals(Body body) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread(std::move(body));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

const unsigned char* bytes_of(const char* text) noexcept {
  return reinterpret_cast<const unsigned char*>(text);  // NOLINT: libwebsockets' text is unsigned
}

}  // namespace

struct WebServer::Parts {
  // A request that is to be answered.
  struct Visit {
    posix::Fd socket{};
    PageOrigin origin{};
  };

  explicit Parts(WebServerOptions all) : options(std::move(all)) {}
  ~Parts() {
    stopping = true;
    if (guard_thread.joinable()) {
      guard->stop();
      guard_thread.join();
    }
    if (context != nullptr) {
      lws_cancel_service(context);
    }
    if (thread.joinable()) {
      thread.join();
    }
    if (context != nullptr) {
      lws_context_destroy(context);
    }
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  bool listen(std::uint16_t at);
  bool start();
  void admit(posix::Fd socket, const PageOrigin& origin);
  void take_visits();
  static int callback(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                      std::size_t size);
  int on_http(lws* wsi, std::string_view path);
  int on_upgrade(lws* wsi) const;
  int answer(lws* wsi, unsigned status, const char* type, std::string_view body);
  int on_connected(lws* wsi, Slot& slot);
  static int on_message(lws* wsi, Connection& connection, std::string_view part);
  int on_writeable(lws* wsi, Connection& connection);
  Access access(lws* wsi) const;
  std::vector<const Subprotocol*> offered(lws* wsi) const;

  WebServerOptions options;
  std::vector<lws_protocols> protocols{};
  lws_retry_bo_t idle{};
  lws_context* context = nullptr;
  lws_vhost* host = nullptr;
  std::vector<std::uint8_t> scratch{};  // what is sent, behind LWS_PRE bytes
  std::size_t pages = 0;
  std::mutex visits_mutex;
  std::vector<Visit> visits{};                    // that came since the server's thread looked
  std::unordered_map<int, PageOrigin> origins{};  // by the socket's descriptor
  std::unique_ptr<ConnectionGuard> guard{};
  std::atomic<bool> stopping = false;
  std::thread guard_thread{};  // last: they use what stands above
  std::thread thread{};
};

bool WebServer::Parts::listen(std::uint16_t at) {
  guard = ConnectionGuard::open(
      {.every_interface = options.every_interface, .port = at, .most_waiting = kMostWaiting},
      [this](posix::Fd socket, const PageOrigin& origin) { admit(std::move(socket), origin); });
  return guard != nullptr;
}

// Of the guard's thread.
void WebServer::Parts::admit(posix::Fd socket, const PageOrigin& origin) {
  {
    const std::scoped_lock lock(visits_mutex);
    visits.push_back({.socket = std::move(socket), .origin = origin});
  }
  lws_cancel_service(context);
}

void WebServer::Parts::take_visits() {
  std::vector<Visit> come;
  {
    const std::scoped_lock lock(visits_mutex);
    come.swap(visits);
  }
  for (const Visit& visit : come) {
    const int fd = dup(visit.socket.get());
    if (fd >= 0) {
      origins[fd] = visit.origin;
      lws_adopt_socket_vhost(host, fd);  // which closes it where it cannot
    }
  }
}

bool WebServer::Parts::start() {
  const KeptSigpipe kept;
  protocols.assign(options.subprotocols.size() + 1, {});  // the last one: their end
  for (std::size_t i = 0; i < options.subprotocols.size(); ++i) {
    protocols[i].name = options.subprotocols[i].name.data();
    protocols[i].callback = &Parts::callback;
    protocols[i].per_session_data_size = sizeof(Slot);
    protocols[i].rx_buffer_size = kMaxPageMessage;
    protocols[i].tx_packet_size = kHugePacket;
  }
  idle.secs_since_valid_ping = kStalledSeconds;
  idle.secs_since_valid_hangup = 2 * kStalledSeconds;
  lws_set_log_level(0, nullptr);
  lws_context_creation_info info{};
  info.port = CONTEXT_PORT_NO_LISTEN_SERVER;  // the guard listens
  info.protocols = protocols.data();
  info.user = this;
  // -1: as they are. int, or in later libwebsockets the system's own types, which are unsigned.
  info.gid = ~decltype(info.gid){0};
  info.uid = ~decltype(info.uid){0};
  info.options = LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_EXPLICIT_VHOSTS;
  info.fd_limit_per_thread =
      static_cast<unsigned>(options.max_pages + kMostWaiting + kSpareDescriptors);
  info.max_http_header_data = 2 * kMostHeaderBytes;
  info.timeout_secs = kRequestSeconds;
  info.timeout_secs_ah_idle = kRequestSeconds;
  info.keepalive_timeout = kRequestSeconds;
  info.retry_and_idle_policy = &idle;
  info.server_string = "stof";
  context = lws_create_context(&info);
  if (context == nullptr) {
    return false;
  }
  host = lws_create_vhost(context, &info);
  if (host == nullptr) {
    lws_context_destroy(context);
    context = nullptr;
    return false;
  }
  return true;
}

// Those of ours that the client offers, in its order; empty where one of them is not ours.
std::vector<const Subprotocol*> WebServer::Parts::offered(lws* wsi) const {
  std::vector<const Subprotocol*> all;
  const std::string list = header(wsi, WSI_TOKEN_PROTOCOL);
  for (const auto part : std::views::split(std::string_view(list), ',')) {
    std::string_view name(part.begin(), part.end());
    name.remove_prefix(std::min(name.find_first_not_of(" \t"), name.size()));
    name = name.substr(0, name.find_last_not_of(" \t") + 1);
    const auto known = std::ranges::find(options.subprotocols, name, &Subprotocol::name);
    if (known == options.subprotocols.end()) {
      return {};
    }
    all.push_back(&*known);
  }
  return all;
}

Access WebServer::Parts::access(lws* wsi) const {
  const std::string host_header = header(wsi, WSI_TOKEN_HOST);
  const std::string origin = header(wsi, WSI_TOKEN_ORIGIN);
  const std::string token = token_of(wsi);
  const std::vector<const Subprotocol*> spoken = offered(wsi);
  const bool foxglove = !spoken.empty() && std::ranges::all_of(spoken, &Subprotocol::foxglove);
  return judge(options.rules,
               {.host = host_header, .origin = origin, .token = token, .foxglove = foxglove});
}

int WebServer::Parts::answer(lws* wsi, unsigned status, const char* type, std::string_view body) {
  constexpr std::pair<const char*, const char*> kAlways[] = {
      {"cache-control:", "no-store"},
      {"connection:", "close"},
      {"cross-origin-opener-policy:", "same-origin"},
      {"cross-origin-resource-policy:", "same-origin"},
      {"permissions-policy:", "camera=(), microphone=(), geolocation=()"},
      {"referrer-policy:", "no-referrer"},
      {"x-content-type-options:", "nosniff"},
      {"x-frame-options:", "DENY"}};
  scratch.assign(LWS_PRE + 4096, 0);
  unsigned char* const begin = scratch.data() + LWS_PRE;
  unsigned char* at = begin;
  unsigned char* const end = scratch.data() + scratch.size();
  if (lws_add_http_common_headers(wsi, status, type, body.size(), &at, end) != 0) {
    return -1;
  }
  for (const auto& [name, value] : kAlways) {
    if (lws_add_http_header_by_name(wsi, bytes_of(name), bytes_of(value),
                                    static_cast<int>(std::string_view(value).size()), &at,
                                    end) != 0) {
      return -1;
    }
  }
  if (lws_add_http_header_by_name(wsi, bytes_of("content-security-policy:"),
                                  bytes_of(options.policy.data()),
                                  static_cast<int>(options.policy.size()), &at, end) != 0 ||
      lws_finalize_write_http_header(wsi, begin, &at, end) != 0) {
    return -1;
  }
  scratch.assign(LWS_PRE, 0);
  scratch.insert(scratch.end(), body.begin(), body.end());
  // What the socket does not take at once libwebsockets keeps.
  if (lws_write(wsi, scratch.data() + LWS_PRE, body.size(), LWS_WRITE_HTTP_FINAL) < 0) {
    return -1;
  }
  return -1;  // one request for each connection: what is left of the answer still goes
}

int WebServer::Parts::on_http(lws* wsi, std::string_view path) {
  constexpr const char* kText = "text/plain; charset=utf-8";
  if (const Access verdict = access(wsi); verdict != Access::kGranted) {
    return answer(wsi, 403, kText, std::string(reason(verdict)) + "\n");
  }
  if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) == 0) {
    return answer(wsi, 405, kText, "only GET\n");
  }
  if (path != "/") {
    return answer(wsi, 404, kText, "there is one page: /\n");
  }
  return answer(wsi, 200, "text/html; charset=utf-8", options.page);
}

// Before a request becomes a WebSocket: 0 lets it.
int WebServer::Parts::on_upgrade(lws* wsi) const {
  unsigned status = 0;
  if (access(wsi) != Access::kGranted) {
    status = HTTP_STATUS_FORBIDDEN;
  } else if (pages >= options.max_pages) {
    status = HTTP_STATUS_SERVICE_UNAVAILABLE;
  } else if (offered(wsi).empty()) {
    status = HTTP_STATUS_BAD_REQUEST;
  }
  if (status == 0) {
    return 0;
  }
  lws_return_http_status(wsi, status, nullptr);
  return -1;
}

int WebServer::Parts::on_connected(lws* wsi, Slot& slot) {
  if (pages >= options.max_pages) {
    return -1;
  }
  const auto known = origins.find(lws_get_socket_fd(wsi));
  PageOrigin page = known == origins.end() ? PageOrigin{} : known->second;
  page.names_origin = !header(wsi, WSI_TOKEN_ORIGIN).empty();
  const std::string_view name = lws_get_protocol(wsi)->name;  // of a copy of ours
  const auto spoken = std::ranges::find(options.subprotocols, name, &Subprotocol::name);
  if (spoken == options.subprotocols.end()) {
    return -1;
  }
  auto conversation =
      spoken->open_conversation({.change = judge_page(options.rules, page, geteuid()),
                                 .pair = judge_pairing(page, geteuid()),
                                 .place = place_of(page)});
  // The slot is libwebsockets' memory: whoever closes the connection deletes it.
  slot.connection = new Connection{.conversation = std::move(conversation)};  // NOLINT
  ++pages;
  return 0;
}

int WebServer::Parts::on_message(lws* wsi, Connection& connection, std::string_view part) {
  const auto end = [wsi](lws_close_status status) {
    lws_close_reason(wsi, status, nullptr, 0);
    return -1;
  };
  if (connection.message.size() + part.size() + lws_remaining_packet_payload(wsi) >
      kMaxPageMessage) {
    return end(LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE);
  }
  if (lws_frame_is_binary(wsi) != 0) {
    return end(LWS_CLOSE_STATUS_UNACCEPTABLE_OPCODE);
  }
  connection.message += part;
  if (lws_is_final_fragment(wsi) == 0 || lws_remaining_packet_payload(wsi) != 0) {
    return 0;
  }
  const bool understood = connection.conversation->take(connection.message);
  connection.message.clear();
  if (!understood) {
    return end(LWS_CLOSE_STATUS_POLICY_VIOLATION);
  }
  lws_callback_on_writable(wsi);
  return 0;
}

int WebServer::Parts::on_writeable(lws* wsi, Connection& connection) {
  lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0);  // what was sent before has left
  scratch.assign(LWS_PRE, 0);
  const std::optional<MessageKind> kind = connection.conversation->next(scratch);
  if (!kind) {
    return 0;
  }
  lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, kStalledSeconds);
  if (lws_write(wsi, scratch.data() + LWS_PRE, scratch.size() - LWS_PRE,
                *kind == MessageKind::kText ? LWS_WRITE_TEXT : LWS_WRITE_BINARY) < 0) {
    return -1;
  }
  lws_callback_on_writable(wsi);
  return 0;
}

int WebServer::Parts::callback(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                               std::size_t size) {
  Parts* const parts =
      wsi == nullptr ? nullptr : static_cast<Parts*>(lws_context_user(lws_get_context(wsi)));
  Slot* const slot = static_cast<Slot*>(user);
  const std::string_view text(static_cast<const char*>(in), in == nullptr ? 0 : size);
  switch (reason) {
    case LWS_CALLBACK_HTTP:
      return parts->on_http(wsi, text);
    case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
      return parts->on_upgrade(wsi);
    case LWS_CALLBACK_ESTABLISHED:
      if (parts->on_connected(wsi, *slot) != 0) {
        return -1;
      }
      lws_callback_on_writable(wsi);
      return 0;
    case LWS_CALLBACK_RECEIVE:
      return slot->connection == nullptr ? -1 : on_message(wsi, *slot->connection, text);
    case LWS_CALLBACK_SERVER_WRITEABLE:
      return slot->connection == nullptr ? -1 : parts->on_writeable(wsi, *slot->connection);
    case LWS_CALLBACK_CLOSED:
      if (slot != nullptr && slot->connection != nullptr) {
        delete std::exchange(slot->connection, nullptr);  // NOLINT: made by on_connected()
        --parts->pages;
      }
      return 0;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
      parts->take_visits();
      for (std::size_t i = 0; i < parts->options.subprotocols.size(); ++i) {
        lws_callback_on_writable_all_protocol(parts->context, &parts->protocols[i]);
      }
      return 0;
    case LWS_CALLBACK_HTTP_BODY:
      return -1;
    default:
      return 0;
  }
}

WebServer::WebServer(std::unique_ptr<Parts> parts) noexcept : parts_(std::move(parts)) {}
WebServer::WebServer(WebServer&&) noexcept = default;
WebServer& WebServer::operator=(WebServer&&) noexcept = default;
WebServer::~WebServer() = default;

std::expected<WebServer, std::string> WebServer::open(WebServerOptions options) {
  auto parts = std::make_unique<Parts>(std::move(options));
  const WebServerOptions& all = parts->options;
  if (!parts->listen(all.port) && !(all.or_any_port && parts->listen(0))) {
    return std::unexpected("TCP port " + std::to_string(all.port) +
                           " cannot be had: give another --http-port, 0 for any free one");
  }
  if (!parts->start()) {
    return std::unexpected("the page's server cannot begin: too many files or too little memory");
  }
  parts->guard_thread = without_signals([raw = parts.get()] { raw->guard->run(); });
  parts->thread = without_signals([raw = parts.get()] {
    while (!raw->stopping && lws_service(raw->context, 0) >= 0) {
    }
  });
  return WebServer(std::move(parts));
}

std::uint16_t WebServer::port() const noexcept { return parts_->guard->port(); }

void WebServer::wake() noexcept { lws_cancel_service(parts_->context); }

}  // namespace stof::viewer

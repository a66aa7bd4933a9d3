#include "host/viewer/web_server.h"

#include <array>
#include <atomic>
#include <csignal>
#include <thread>
#include <utility>
#include <vector>

#include <libwebsockets.h>
#include <unistd.h>

namespace stof::viewer {
namespace {

constexpr int kStalledSeconds = 10;
constexpr int kRequestSeconds = 4;  // that a request may take to come
constexpr std::size_t kMostHeaderBytes = 2048;
// Requests beside the connected pages; what comes then waits to be accepted.
constexpr unsigned kSpareConnections = 16;
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
  explicit Parts(WebServerOptions all) : options(std::move(all)) {}
  ~Parts() {
    stopping = true;
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
  static int callback(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                      std::size_t size);
  int on_http(lws* wsi, std::string_view path);
  int on_upgrade(lws* wsi) const;
  int answer(lws* wsi, unsigned status, const char* type, std::string_view body);
  int on_connected(lws* wsi, Slot& slot);
  static int on_message(lws* wsi, Connection& connection, std::string_view part);
  int on_writeable(lws* wsi, Connection& connection);
  Access access(lws* wsi) const;

  WebServerOptions options;
  std::array<lws_protocols, 2> protocols{};
  lws_retry_bo_t idle{};
  lws_context* context = nullptr;
  lws_vhost* host = nullptr;
  std::vector<std::uint8_t> scratch{};  // what is sent, behind LWS_PRE bytes
  std::size_t pages = 0;
  std::atomic<bool> stopping = false;
  std::thread thread{};  // last: it uses what stands above
};

bool WebServer::Parts::listen(std::uint16_t at) {
  const KeptSigpipe kept;
  protocols = {};
  protocols[0].name = options.subprotocol.data();
  protocols[0].callback = &Parts::callback;
  protocols[0].per_session_data_size = sizeof(Slot);
  protocols[0].rx_buffer_size = kMaxPageMessage;
  protocols[0].tx_packet_size = kHugePacket;
  idle.secs_since_valid_ping = kStalledSeconds;
  idle.secs_since_valid_hangup = 2 * kStalledSeconds;
  lws_set_log_level(0, nullptr);
  lws_context_creation_info info{};
  info.port = at;
  info.iface = options.every_interface ? nullptr : "127.0.0.1";
  info.protocols = protocols.data();
  info.user = this;
  // -1: as they are. int, or in later libwebsockets the system's own types, which are unsigned.
  info.gid = ~decltype(info.gid){0};
  info.uid = ~decltype(info.uid){0};
  info.options = LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_EXPLICIT_VHOSTS |
                 LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND;
  info.fd_limit_per_thread = static_cast<unsigned>(options.max_pages) + kSpareConnections;
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

Access WebServer::Parts::access(lws* wsi) const {
  const std::string host_header = header(wsi, WSI_TOKEN_HOST);
  const std::string origin = header(wsi, WSI_TOKEN_ORIGIN);
  const std::string token = token_of(wsi);
  return judge(options.rules, {.host = host_header, .origin = origin, .token = token});
}

int WebServer::Parts::answer(lws* wsi, unsigned status, const char* type, std::string_view body) {
  constexpr std::pair<const char*, const char*> kAlways[] = {
      {"cache-control:", "no-store"},
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
  return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
}

int WebServer::Parts::on_http(lws* wsi, std::string_view path) {
  constexpr const char* kText = "text/plain; charset=utf-8";
  if (const Access verdict = access(wsi); verdict != Access::kGranted) {
    return answer(wsi, 403, kText, std::string(reason(verdict)) + "\n");
  }
  if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) == 0) {
    answer(wsi, 405, kText, "only GET\n");
    return -1;  // with whatever body it has
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
  } else if (header(wsi, WSI_TOKEN_PROTOCOL) != options.subprotocol) {
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
  PageOrigin page = origin_of(lws_get_socket_fd(wsi));
  page.names_origin = !header(wsi, WSI_TOKEN_ORIGIN).empty();
  slot.connection = new Connection{
      // NOLINT
      .conversation = options.open_conversation(judge_page(options.rules, page, geteuid()))};
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
      lws_callback_on_writable_all_protocol(parts->context, parts->protocols.data());
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
  parts->thread = without_signals([raw = parts.get()] {
    while (!raw->stopping && lws_service(raw->context, 0) >= 0) {
    }
  });
  return WebServer(std::move(parts));
}

std::uint16_t WebServer::port() const noexcept {
  return static_cast<std::uint16_t>(lws_get_vhost_listen_port(parts_->host));
}

void WebServer::wake() noexcept { lws_cancel_service(parts_->context); }

}  // namespace stof::viewer

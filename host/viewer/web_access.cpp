#include "host/viewer/web_access.h"

#include <algorithm>
#include <array>
#include <span>

#include <arpa/inet.h>

#include "firmware/wire/crypto/crypto.h"

namespace stof::viewer {
namespace {

constexpr std::size_t kTokenBytes = 16;

char lower(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_name(std::string_view a, std::string_view b) noexcept {
  if (a.size() != b.size()) {
    return false;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (lower(a[i]) != lower(b[i])) {
      return false;
    }
  }
  return true;
}

bool digits(std::string_view text) noexcept {
  return !text.empty() && text.size() <= 5 &&
         text.find_first_not_of("0123456789") == std::string_view::npos;
}

// Without the port; empty where what is behind the name is none.
std::string_view name_of_host(std::string_view host) noexcept {
  const std::size_t end = host.starts_with('[') ? host.find(']') + 1 : host.rfind(':');
  if (host.starts_with('[') && end == 0) {
    return {};
  }
  if (end == std::string_view::npos || end == host.size()) {
    return host;
  }
  return host[end] == ':' && digits(host.substr(end + 1)) ? host.substr(0, end)
                                                          : std::string_view{};
}

// An address in digits is no name that a name server could answer for.
bool literal(std::string_view name, bool any) noexcept {
  if (name == "127.0.0.1" || name == "[::1]") {
    return true;
  }
  std::array<char, INET6_ADDRSTRLEN> text{};
  const bool v6 = name.size() > 2 && name.front() == '[' && name.back() == ']';
  const std::string_view inner = v6 ? name.substr(1, name.size() - 2) : name;
  if (!any || inner.empty() || inner.size() >= text.size()) {
    return false;
  }
  inner.copy(text.data(), inner.size());
  std::array<unsigned char, 16> address{};
  return inet_pton(v6 ? AF_INET6 : AF_INET, text.data(), address.data()) == 1;
}

bool own_name(const AccessRules& rules, std::string_view name) noexcept {
  if (same_name(name, "localhost") || literal(name, rules.any_address)) {
    return true;
  }
  const std::string& own = rules.host_name;
  if (!rules.any_address || own.empty() || name.size() < own.size() ||
      !same_name(name.substr(0, own.size()), own)) {
    return false;
  }
  const std::string_view rest = name.substr(own.size());
  return rest.empty() || same_name(rest, ".local");
}

bool own_origin(const WebRequest& request) noexcept {
  constexpr std::string_view kScheme = "http://";
  return request.origin.empty() || (request.origin.starts_with(kScheme) &&
                                    same_name(request.origin.substr(kScheme.size()), request.host));
}

bool foxglove_origin(const AccessRules& rules, const WebRequest& request) noexcept {
  return request.foxglove &&
         std::ranges::any_of(rules.foxglove_origins, [&](const std::string& one) {
           return same_name(one, request.origin);
         });
}

}  // namespace

const char* reason(Access access) noexcept {
  switch (access) {
    case Access::kGranted:
      return "granted";
    case Access::kNoHost:
      return "the request does not name its host";
    case Access::kForeignHost:
      return "the address names another host: open the address that stof view prints";
    case Access::kForeignPage:
      return "a page of another site asks";
    case Access::kNoToken:
      return "the address lacks its token: open the address that stof view prints";
  }
  return "";
}

Access judge(const AccessRules& rules, const WebRequest& request) noexcept {
  if (request.host.empty()) {
    return Access::kNoHost;
  }
  if (!own_name(rules, name_of_host(request.host))) {
    return Access::kForeignHost;
  }
  if (!own_origin(request) && !foxglove_origin(rules, request)) {
    return Access::kForeignPage;
  }
  if (!rules.token.empty() && (request.token.size() != rules.token.size() ||
                               !wire::equal_secrets(std::as_bytes(std::span(request.token)),
                                                    std::as_bytes(std::span(rules.token))))) {
    return Access::kNoToken;
  }
  return Access::kGranted;
}

std::string random_token() {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::array<std::byte, kTokenBytes> bytes{};
  wire::start_crypto();
  wire::fill_random(bytes);
  std::string text;
  for (const std::byte byte : bytes) {
    text += kDigits[std::to_integer<std::size_t>(byte >> 4)];
    text += kDigits[std::to_integer<std::size_t>(byte & std::byte{15})];
  }
  return text;
}

}  // namespace stof::viewer

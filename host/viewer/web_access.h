#pragma once

#include <string>
#include <string_view>
#include <vector>

// Who may open the viewer's page. A browser tells by Host which name its user typed or a script
// asked for, and by Origin whose page asks: no other site may read or speak through the user's
// browser.
namespace stof::viewer {

// What a request said of itself. Empty: it did not say.
struct WebRequest {
  std::string_view host{};    // of the header Host: "localhost:7570"
  std::string_view origin{};  // of the header Origin: "http://localhost:7570"
  std::string_view token{};   // of the address: "?token=..."
  bool foxglove = false;      // asks for a subprotocol of Foxglove and no other one
};

enum class Access : unsigned char {
  kGranted,
  kNoHost,       // HTTP/1.0, or more than one
  kForeignHost,  // a name that is not this machine's: DNS rebinding
  kForeignPage,  // a page of another site
  kNoToken,      // none, or a wrong one
};
// "a page of another site asks": one line, without anything of the request.
const char* reason(Access access) noexcept;

struct AccessRules {
  std::string host_name{};   // this machine's, also taken with ".local" behind it
  std::string token{};       // that every request has to carry; empty: none
  bool lan_control = false;  // whoever has the token may change things, see page_rights.h
  bool any_address = false;  // literal addresses other than loopback ones are taken as Host
  // "https://app.foxglove.dev": of programs that may look by Foxglove's protocol beside pages of
  // this server.
  std::vector<std::string> foxglove_origins{};
};

// Host has to be localhost, a literal address or this machine's name, with any port (of a tunnel).
// Origin has to be http:// and Host, or one of foxglove_origins where Foxglove's protocol is asked
// for, or absent: no browser asks for a WebSocket without it. How
// long it takes does not depend on how much of the token is right.
Access judge(const AccessRules& rules, const WebRequest& request) noexcept;

// 32 hexadecimal digits, 128 random bits.
std::string random_token();

}  // namespace stof::viewer

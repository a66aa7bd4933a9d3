#include "host/viewer/page_rights.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iterator>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace stof::viewer {
namespace {

std::string_view word_of(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
  const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

// "0100007F:1D92", which the table has as this machine's words; also behind an IPv6 prefix.
std::string end_text(std::uint32_t address, std::uint16_t port) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%08X:%04X", address, unsigned{port});
  return text.data();
}

bool is_end(std::string_view word, const std::string& end) {
  constexpr std::string_view kMapped = "0000000000000000FFFF0000";
  return word == end || (word.size() == kMapped.size() + end.size() && word.starts_with(kMapped) &&
                         word.ends_with(end));
}

std::string text_of(const char* file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

bool address_of(int (*ask)(int, sockaddr*, socklen_t*), int socket, sockaddr_in& address) {
  socklen_t length = sizeof address;
  return ask(socket, reinterpret_cast<sockaddr*>(&address), &length) == 0 &&  // NOLINT
         address.sin_family == AF_INET;
}

}  // namespace

const char* reason(PageRight right) noexcept {
  switch (right) {
    case PageRight::kGranted:
      return "";
    case PageRight::kOtherMachine:
      return "only a page on the machine of stof view changes anything, unless --lan-control lets "
             "others";
    case PageRight::kOtherUser:
      return "only a page of the user who started stof view changes anything";
    case PageRight::kNoPage:
      return "only a page in a browser changes anything: use stof config";
  }
  return "";
}

const char* pairing_reason(PageRight right) noexcept {
  switch (right) {
    case PageRight::kGranted:
      return "";
    case PageRight::kOtherMachine:
      return "only a page on the machine of stof view pairs: open it there or through ssh -L, or "
             "use stof pair there";
    case PageRight::kOtherUser:
      return "only a page of the user who started stof view pairs: the key is that user's";
    case PageRight::kNoPage:
      return "only a page in a browser pairs: use stof pair";
  }
  return "";
}

std::string place_of(const PageOrigin& page) {
  return page.loopback ? "this computer" : page.address;
}

PageRight judge_page(const AccessRules& rules, const PageOrigin& page,
                     std::uint32_t user) noexcept {
  if (!page.names_origin) {
    return PageRight::kNoPage;
  }
  return rules.lan_control ? PageRight::kGranted  // who has the token
                           : judge_pairing(page, user);
}

PageRight judge_pairing(const PageOrigin& page, std::uint32_t user) noexcept {
  if (!page.names_origin) {
    return PageRight::kNoPage;
  }
  if (!page.loopback) {
    return PageRight::kOtherMachine;
  }
  return page.user && (*page.user == user || *page.user == 0) ? PageRight::kGranted
                                                              : PageRight::kOtherUser;
}

std::optional<std::uint32_t> user_in(std::string_view table, std::uint32_t from_address,
                                     std::uint16_t from, std::uint16_t to) {
  constexpr int kWordsBetween = 4;  // state, queues, timer, retransmissions
  const std::string own = end_text(from_address, from);
  while (!table.empty()) {
    const std::size_t end = std::min(table.find('\n'), table.size());
    std::string_view line = table.substr(0, end);
    table.remove_prefix(std::min(end + 1, table.size()));
    word_of(line);
    const std::string_view local = word_of(line);
    const std::string_view remote = word_of(line);
    // Whatever address of this machine was asked for, the port is ours.
    if (!is_end(local, own) || remote.size() < 5 ||
        remote.substr(remote.size() - 5) != end_text(0, to).substr(8)) {
      continue;
    }
    for (int i = 0; i < kWordsBetween; ++i) {
      word_of(line);
    }
    const std::string_view user = word_of(line);
    std::uint32_t number = 0;
    const auto [rest, error] = std::from_chars(user.data(), user.data() + user.size(), number);
    if (error == std::errc() && rest == user.data() + user.size()) {
      return number;
    }
  }
  return std::nullopt;
}

PageOrigin origin_of(int socket) {
  constexpr std::uint32_t kLoopback = 127;
  sockaddr_in peer{};
  sockaddr_in own{};
  PageOrigin page;
  if (!address_of(&getpeername, socket, peer) || !address_of(&getsockname, socket, own)) {
    return page;
  }
  page.loopback = ntohl(peer.sin_addr.s_addr) >> 24 == kLoopback;
  std::array<char, INET_ADDRSTRLEN> text{};
  if (inet_ntop(AF_INET, &peer.sin_addr, text.data(), text.size()) != nullptr) {
    page.address = text.data();
  }
  for (const char* const file : {"/proc/net/tcp", "/proc/net/tcp6"}) {
    if (page.loopback && !page.user) {
      page.user =
          user_in(text_of(file), peer.sin_addr.s_addr, ntohs(peer.sin_port), ntohs(own.sin_port));
    }
  }
  return page;
}

}  // namespace stof::viewer

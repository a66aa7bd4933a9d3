#include "host/cli/fault.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ranges>

#include <nlohmann/json.hpp>

#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/client/printable.h"
#include "posix/local_socket.h"
#include "posix/poll.h"

namespace stof::host {
namespace {

constexpr std::chrono::seconds kPatience{1};

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> all;
  for (const auto part : std::views::split(text, at)) {
    all.emplace_back(part.begin(), part.end());
  }
  return all;
}

std::string ask(const std::string& socket, std::string_view order) {
  const auto fail = [&](const std::string& what) {
    return Failure(Exit::kFailure, socket + ": " + what);
  };
  const auto way = posix::LocalSocket::connect(socket);
  if (!way || way->send(order) != 0) {
    const int error = way ? errno : way.error();
    throw fail(error == EACCES || error == EPERM
                   ? "belongs to another user: ask as the one who started stofd"
                   : "no emulated sensor listens there: start stofd --fault-socket PATH");
  }
  std::array<pollfd, 1> entries{{{.fd = way->fd(), .events = POLLIN, .revents = 0}}};
  std::array<char, posix::LocalSocket::kMostBytes> space{};
  const auto ready = posix::wait_for(entries, kPatience);
  const auto size = ready && *ready > 0 ? way->receive(space) : std::unexpected(EAGAIN);
  if (!size) {
    throw fail("does not answer: is it stofd's?");
  }
  return {space.data(), *size};
}

[[noreturn]] void fail_as_no_list(const std::string& socket) {
  throw Failure(Exit::kFailure, socket +
                                    ": answers with what is no list of faults: use stof and "
                                    "stofd of one version");
}

// "DEVICE KIND EDGES KIND,KIND,...".
DeviceFaults device_in(const std::string& socket, const std::string& line) {
  constexpr std::size_t kMostDigits = 9;
  std::vector<std::string> words = split(line, ' ');
  const bool shown = std::ranges::all_of(line, [](char c) { return c >= ' ' && c <= '~'; });
  if (!shown || words.size() != 4 ||
      (words[2] != "-" &&
       (words[2].empty() || words[2].size() > kMostDigits ||
        !std::ranges::all_of(words[2], [](char c) { return c >= '0' && c <= '9'; })))) {
    fail_as_no_list(socket);
  }
  return {.device = std::move(words[0]),
          .now = std::move(words[1]),
          .edges = std::move(words[2]),
          .kinds = split(words[3], ',')};
}

void print(const std::vector<DeviceFaults>& devices, bool json) {
  if (json) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const DeviceFaults& one : devices) {
      all.push_back({{"device", one.device},
                     {"fault", one.now},
                     {"edges", one.edges == "-" ? nlohmann::ordered_json()
                                                : nlohmann::ordered_json(std::stoul(one.edges))},
                     {"faults", one.kinds}});
    }
    say_json(all);
    return;
  }
  for (const DeviceFaults& one : devices) {
    std::string kinds;
    for (const std::string& kind : one.kinds) {
      kinds += " " + kind;
    }
    std::string now = one.now;
    if (one.now != "none") {
      now += one.edges == "-"
                 ? " until it is ended"
                 : " at " + one.edges + (one.edges == "1" ? " edge more" : " edges more");
    }
    std::string line = one.device;
    line.resize(std::max(line.size(), std::size_t{8}), ' ');
    line.append(" ").append(now).append(" (it can:").append(kinds).append(")");
    say(line);
  }
}

void fault(const FaultOptions& options) {
  std::vector<DeviceFaults> devices;
  for (const std::string& order : options.orders) {
    devices = order_fault(options.socket, order);
  }
  if (options.orders.empty()) {
    devices = order_fault(options.socket, "list");
  }
  print(devices, options.json);
}

}  // namespace

std::vector<DeviceFaults> order_fault(const std::string& socket, std::string_view order) {
  const std::string answer = ask(socket, order);
  const std::vector<std::string> lines = split(answer, '\n');
  constexpr std::string_view kRefused = "refused: ";
  if (answer.starts_with(kRefused)) {
    throw Failure(Exit::kBadInput, std::string(order) + ": " +
                                       client::printable(lines.front().substr(kRefused.size())));
  }
  if (!answer.starts_with("ok\n")) {
    fail_as_no_list(socket);
  }
  std::vector<DeviceFaults> devices;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (!lines[i].empty()) {
      devices.push_back(device_in(socket, lines[i]));
    }
  }
  return devices;
}

void add_fault(CLI::App& app, FaultOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "fault", "Make an emulated sensor fail while it runs: a camera that is unplugged, dark, ...");
  command.footer(
      "Example: stof fault /run/user/1000/faults pmd:vanish:60\n"
      "         stof fault /run/user/1000/faults pmd:none\n"
      "scripts/run prints the path of its own socket.\n"
      "Kinds: drop, delay, repeat, tear, corrupt, vanish (unplugged), freeze (old pixels), dark "
      "(no lamp), hang (old pixels until it is opened again).\n"
      "Ends with 0 (done), 1 (no emulated sensor answers) or 2 (bad input).");
  command.add_option("SENSOR", options.socket, "The socket of stofd --fault-socket PATH")
      ->required();
  command.add_option("FAULT", options.orders,
                     "DEVICE:KIND[:EDGES], of trigger, stereo or pmd: at so many edges, or until "
                     "DEVICE:none; none: say what each can have, and has");
  command.add_flag("--json", options.json, "Print JSON");
  command.callback([&options] { fault(options); });
}

}  // namespace stof::host

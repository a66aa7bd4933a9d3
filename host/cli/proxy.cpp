#include "host/cli/proxy.h"

#include <cstdio>

#include "dataset/files/file.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/stop_signal.h"
#include "host/netem/relay.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

netem::Duration milliseconds(double ms) {
  return std::chrono::duration_cast<netem::Duration>(std::chrono::duration<double, std::milli>(ms));
}

netem::Direction direction(const std::string& only) {
  if (only == "down") {
    return netem::Direction::kDown;
  }
  return only == "up" ? netem::Direction::kUp : netem::Direction::kBoth;
}

netem::RelayOptions relay_options(const ProxyOptions& options) {
  constexpr double kPercent = 0.01;
  return {.listen_address = options.bind,
          .listen_port = options.port,
          .upstream = options.to,
          .impairment = {.loss = kPercent * options.loss_percent,
                         .burst = options.burst,
                         .duplicate = kPercent * options.duplicate_percent,
                         .corrupt = kPercent * options.corrupt_percent,
                         .reorder = options.reorder,
                         .delay = milliseconds(options.delay_ms),
                         .jitter = milliseconds(options.jitter_ms),
                         .seed = options.seed},
          .only = direction(options.only)};
}

std::string way_text(const char* name, const netem::Impairment::Counts& counts) {
  return printed(", %s %llu in %llu out %llu lost %llu twice %llu damaged", name,
                 static_cast<unsigned long long>(counts.in),
                 static_cast<unsigned long long>(counts.out),
                 static_cast<unsigned long long>(counts.lost + counts.overflowed),
                 static_cast<unsigned long long>(counts.duplicated),
                 static_cast<unsigned long long>(counts.corrupted));
}

nlohmann::ordered_json way_json(const netem::Impairment::Counts& counts) {
  return {{"in", counts.in},
          {"out", counts.out},
          {"lost", counts.lost + counts.overflowed},
          {"duplicated", counts.duplicated},
          {"corrupted", counts.corrupted}};
}

void print_line(double seconds, const ProxyOptions& options, const netem::Relay& relay) {
  const netem::RelayCounts counts = relay.counts();
  if (options.json) {
    say_json_line({{"seconds", seconds},
                   {"port", relay.port()},
                   {"to", options.to},
                   {"clients", counts.clients},
                   {"down", way_json(counts.down)},
                   {"up", way_json(counts.up)}});
    return;
  }
  say(printed("%6.1f s  %zu clients", seconds, counts.clients) + way_text("down", counts.down) +
      way_text("up", counts.up));
}

}  // namespace

void proxy(const ProxyOptions& options) {
  stop_on_signals();
  const auto relay = netem::Relay::open(relay_options(options));
  if (!relay) {
    throw Failure(Exit::kBadInput, relay.error());
  }
  if (!options.json) {
    say("passing UDP " + options.bind + ":" + std::to_string((*relay)->port()) + " to " +
        options.to);
  }
  if (!options.port_file.empty()) {
    value_or_fail(dataset::write_whole(options.port_file, std::to_string((*relay)->port()) + "\n"));
  }
  constexpr std::chrono::seconds kLine{1};
  constexpr std::chrono::milliseconds kLook{100};
  const netem::Time began = netem::Time::clock::now();
  netem::Time next = began + kLine;
  while (!asked_to_stop()) {
    if (!(*relay)->run(kLook)) {
      throw Failure(Exit::kFailure, "the socket failed: start again");
    }
    const netem::Time now = netem::Time::clock::now();
    if (now >= next) {
      print_line(std::chrono::duration<double>(now - began).count(), options, **relay);
      next += kLine;
    }
  }
  print_line(std::chrono::duration<double>(netem::Time::clock::now() - began).count(), options,
             **relay);
}

void add_proxy(CLI::App& app, ProxyOptions& options) {
  const CLI::Range percent(0.0, 100.0);
  constexpr double kMostMs = 10'000;
  CLI::App& command = *app.add_subcommand(
      "proxy", "Pass datagrams between receivers and a sensor as a bad network would");
  show_example(command, "stof proxy --listen 7570 --to 192.168.1.20:7560 --loss 1",
               "Ends with 0 (interrupted), 1 (a socket failed, or the output cannot be written) or "
               "2 (bad input).");
  command.add_option("--listen", options.port, "UDP port for the receivers, 0: any free one")
      ->required();
  command.add_option("--bind", options.bind, "Address of the interface to listen at")
      ->capture_default_str();
  command.add_option("--to", options.to, "HOST:PORT of the sensor")->required();
  command.add_option("--loss", options.loss_percent, "Percent of the datagrams that are lost")
      ->check(percent);
  command.add_option("--burst", options.burst, "Mean number of datagrams lost in a row")
      ->check(CLI::Range(1.0, 10'000.0));
  command.add_option("--duplicate", options.duplicate_percent, "Percent that arrive twice")
      ->check(percent);
  command.add_option("--corrupt", options.corrupt_percent, "Percent with one to three wrong bits")
      ->check(percent);
  command.add_option("--reorder", options.reorder, "How many later datagrams may overtake one")
      ->check(CLI::Range(0, 1000));
  command.add_option("--delay", options.delay_ms, "Delay of each, milliseconds")
      ->check(CLI::Range(0.0, kMostMs));
  command.add_option("--jitter", options.jitter_ms, "More delay, up to this, milliseconds")
      ->check(CLI::Range(0.0, kMostMs));
  command.add_option("--seed", options.seed, "Of the random numbers")->capture_default_str();
  command.add_option("--only", options.only, "The way that is bad: from the sensor is down")
      ->check(CLI::IsMember({"both", "down", "up"}))
      ->capture_default_str();
  command.add_option("--port-file", options.port_file,
                     "File that gets the number of the opened port");
  command.add_flag("--json", options.json, "A JSON object a second, a line each, and at the end");
  command.callback([&options] { proxy(options); });
}

}  // namespace stof::host

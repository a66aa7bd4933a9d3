#include "tests/bench/link/link_bench.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <utility>

#include "host/client/control/user_keys.h"

namespace stof::bench {
namespace {

using Entry = std::pair<const char*, std::uint64_t>;

std::string object(std::span<const Entry> entries) {
  std::string text = "{";
  for (const auto& [name, value] : entries) {
    text += (text.size() > 1 ? ",\"" : "\"") + std::string(name) + "\":" + std::to_string(value);
  }
  return text + "}";
}

}  // namespace

bool Order::advances(const client::Frame& frame) {
  const std::uint32_t session = frame.origin.session_id;
  new_session_ = sessions_.empty() || sessions_.back() != session;
  const bool returned = new_session_ && std::ranges::find(sessions_, session) != sessions_.end();
  const bool advanced = new_session_ || (newer(frame.stamp.number, newest_.number) &&
                                         newer(frame.stamp.freshness, newest_.freshness));
  if (new_session_) {
    sessions_.push_back(session);
  }
  newest_ = frame.stamp;
  return advanced && !returned;
}

std::string quantiles(std::string_view name, std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&values](double share) {
    const double last = values.empty() ? 0 : static_cast<double>(values.size() - 1);
    return values.empty() ? 0 : values[static_cast<std::size_t>(share * last + 0.5)];
  };
  std::array<char, 200> text{};
  const int length = static_cast<int>(name.size());
  std::snprintf(text.data(), text.size(),
                R"("%.*s_p10":%.3f,"%.*s_p50":%.3f,"%.*s_p99":%.3f,"%.*s_max":%.3f)", length,
                name.data(), at(0.1), length, name.data(), at(0.5), length, name.data(), at(0.99),
                length, name.data(), at(1));
  return text.data();
}

std::string json(const client::Statistics& s) {
  return object(std::array<Entry, 25>{{{"packets_ok", s.packets_ok},
                                       {"truncated", s.truncated},
                                       {"bad_magic", s.bad_magic},
                                       {"bad_version", s.bad_version},
                                       {"bad_length", s.bad_length},
                                       {"bad_crc", s.bad_crc},
                                       {"bad_field", s.bad_field},
                                       {"unknown", s.unknown},
                                       {"oversized", s.oversized},
                                       {"foreign", s.foreign},
                                       {"duplicate", s.duplicate},
                                       {"late", s.late},
                                       {"frames_complete", s.frames_complete},
                                       {"frames_incomplete", s.frames_incomplete},
                                       {"frames_stale", s.frames_stale},
                                       {"frames_lost", s.frames_lost},
                                       {"frames_dropped", s.frames_dropped},
                                       {"packets_missing", s.packets_missing},
                                       {"recovered", s.recovered},
                                       {"events_dropped", s.events_dropped},
                                       {"sessions", s.sessions},
                                       {"socket_drops", s.socket_drops},
                                       {"not_signed", s.not_signed},
                                       {"forged", s.forged},
                                       {"packets", s.packets()}}});
}

std::string json(const wire::ControlCounters& c) {
  return object(std::array<Entry, 15>{{{"accepted", c.accepted},
                                       {"truncated", c.truncated},
                                       {"bad_magic", c.bad_magic},
                                       {"bad_version", c.bad_version},
                                       {"bad_length", c.bad_length},
                                       {"bad_crc", c.bad_crc},
                                       {"bad_field", c.bad_field},
                                       {"not_control", c.not_control},
                                       {"foreign", c.foreign},
                                       {"too_short", c.too_short},
                                       {"cookies", c.cookies},
                                       {"busy", c.busy},
                                       {"overrun", c.overrun},
                                       {"unknown_key", c.forged},
                                       {"replayed", c.replayed}}});
}

double milliseconds(client::Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

std::int64_t nanoseconds(client::Time time) {
  return std::chrono::nanoseconds(time.time_since_epoch()).count();
}

client::Receiver subscribe(const std::string& sensor, const std::string& keys) {
  client::ReceiverOptions options;
  options.sensor = sensor;
  if (!keys.empty()) {
    options.subscription.signed_streams = true;
    options.subscription.keys = client::read_user_keys(keys).value_or(wire::KeyTable{});
  }
  auto receiver = client::Receiver::open(options);
  if (!receiver) {
    std::fprintf(stderr, "stof_link_bench: %s\n", receiver.error().message.c_str());
    std::exit(2);  // NOLINT(concurrency-mt-unsafe): nothing to undo in any thread
  }
  return std::move(*receiver);
}

namespace {

struct Command {
  std::string_view name;
  std::size_t words;  // one more may follow
  int (*run)(const Words&);
};

int run(const Words& words) {
  constexpr std::array<Command, 5> kCommands{{{"receive", 2, &receive},
                                              {"attack", 5, &attack},
                                              {"cycles", 3, &cycles},
                                              {"flood", 4, &flood},
                                              {"compare", 3, &compare}}};
  for (const Command& command : kCommands) {
    const std::size_t given = words.size();
    if (given > 0 && words[0] == command.name && given > command.words &&
        given <= command.words + 2) {
      return command.run(Words(words.begin() + 1, words.end()));
    }
  }
  std::fputs(
      "stof_link_bench receive SENSOR SECONDS [KEYS] | cycles SENSOR COUNT CLIENTS |\n"
      "  flood HOST:PORT COUNT RATE SEED | attack HOST:PORT COUNT RATE SEED KEYS |\n"
      "  compare SENSOR IMPAIRED FRAMES\n",
      stderr);
  return 2;
}

}  // namespace
}  // namespace stof::bench

int main(int argc, char** argv) {
  const std::span<char*> arguments(argv, static_cast<std::size_t>(argc));
  return stof::bench::run({arguments.begin() + 1, arguments.end()});
}

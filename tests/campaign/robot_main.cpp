// campaign_robot HOST:PORT: libstof's receiver as a robot runs it, a look every 5 ms. A JSON object
// a frame and a sign that something is wrong, with the machine's time; ends with its input.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

#include <poll.h>
#include <unistd.h>

#include "firmware/wire/messages/conditions.h"
#include "host/client/receiver.h"

namespace {

using namespace stof;
using namespace std::chrono_literals;

constexpr std::uint32_t kHarmless = 1U << static_cast<unsigned>(wire::Condition::kUnpaired) |
                                    1U << static_cast<unsigned>(wire::Condition::kSettingsChanged) |
                                    1U << static_cast<unsigned>(wire::Condition::kSettingsUnsaved);

double seconds(client::Time at) {
  return std::chrono::duration<double>(at.time_since_epoch()).count();
}

void say(const char* sign, std::uint64_t value) {
  std::printf("{\"sign\": \"%s\", \"value\": %llu, \"at\": %.6f}\n", sign,
              static_cast<unsigned long long>(value), seconds(std::chrono::steady_clock::now()));
}

void tell(const client::Frame& frame) {
  const auto sensors = frame.info ? wire::sensors_of(*frame.info) : wire::Sensors::kNoSensor;
  std::printf(
      "{\"frame\": %u, \"session\": %u, \"freshness\": %u, \"exposure\": %.6f, \"whole\": %d, "
      "\"sensors\": %d, \"health\": %d, \"arrived\": %.6f, \"at\": %.6f}\n",
      frame.stamp.number, frame.origin.session_id, frame.stamp.freshness,
      static_cast<double>(frame.stamp.exposure_middle_ns) * 1e-9, frame.complete() ? 1 : 0,
      static_cast<int>(sensors), static_cast<int>(frame.stamp.health), seconds(frame.last_packet),
      seconds(std::chrono::steady_clock::now()));
}

bool told_to_end() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  return poll(&input, 1, 0) > 0;
}

// What has changed since the look before.
struct Signs {
  bool silent = true;
  bool restarted = false;
  bool forged = false;
  std::uint32_t active = 0;

  void look(client::Receiver& receiver) {
    const client::LinkState link = receiver.link();
    if (link.silent != silent) {
      say("silent", link.silent ? 1 : 0);
    }
    if (link.restarted != restarted) {
      say("restarted", link.restarted ? 1 : 0);
    }
    if (link.forged_traffic != forged) {
      say("forged", link.forged_traffic ? 1 : 0);
    }
    silent = link.silent;
    restarted = link.restarted;
    forged = link.forged_traffic;
    while (const auto event = receiver.take_event()) {
      const auto condition = static_cast<unsigned>(event->report.condition);
      if (event->report.active != 0 && (condition >= 32 || (kHarmless >> condition & 1U) == 0)) {
        say("condition", condition);
      }
    }
    const auto& health = receiver.health();
    const std::uint32_t now = health ? health->active & ~kHarmless : 0;
    if (now != active) {
      say("health", now);
    }
    active = now;
  }
};

}  // namespace

int main(int count, char** values) {
  if (count != 2) {
    std::fputs("campaign_robot HOST:PORT\n", stderr);
    return 2;
  }
  auto receiver = client::Receiver::open({.sensor = values[1]});
  if (!receiver) {
    std::fprintf(stderr, "campaign_robot: %s\n", receiver.error().message.c_str());
    return 1;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  say("open", 1);
  Signs signs;
  while (!told_to_end()) {
    if (const auto frame = receiver->next(5ms)) {
      tell(*frame);
    }
    signs.look(*receiver);
  }
  const client::Statistics& seen = receiver->statistics();
  std::printf("{\"old\": %llu, \"lost\": %llu, \"stale\": %llu, \"socket_drops\": %llu}\n",
              static_cast<unsigned long long>(seen.frames_old),
              static_cast<unsigned long long>(seen.frames_lost),
              static_cast<unsigned long long>(seen.frames_stale),
              static_cast<unsigned long long>(seen.socket_drops));
  return 0;
}

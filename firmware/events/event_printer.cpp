#include "firmware/events/event_printer.h"

#include <chrono>
#include <cstdio>
#include <optional>

#include "firmware/events/log_text.h"

namespace stof::firmware {

void say(const std::string& line) {
  std::printf("stofd: %s\n", line.c_str());
  std::fflush(stdout);
}

Teller::Teller(Events& events) : events_(events), thread_([this] { run(); }) {}

Teller::~Teller() {
  done_.store(true);
  thread_.join();
  tell();
}

void Teller::run() {
  while (!done_.load()) {
    tell();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void Teller::tell() {
  while (const std::optional<Event> event = events_.take()) {
    say(describe(*event));
  }
}

}  // namespace stof::firmware

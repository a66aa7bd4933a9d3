#include "firmware/events/event_printer.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <optional>

#include "firmware/events/log_text.h"

namespace stof::firmware {

void print_line(std::string_view line) {
  std::printf("stofd: %.*s\n", static_cast<int>(line.size()), line.data());
  std::fflush(stdout);
}

EventPrinter::EventPrinter(Events& events) : events_(events), thread_([this] { run(); }) {}

EventPrinter::~EventPrinter() {
  done_.store(true);
  thread_.join();
  print_noted();
}

void EventPrinter::run() {
  while (!done_.load()) {
    print_noted();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void EventPrinter::print_noted() {
  while (const std::optional<Event> event = events_.take()) {
    std::array<char, kMostLine> space;
    settings::PagedWriter line(space);
    describe(*event, line);
    print_line(line.text());
  }
}

}  // namespace stof::firmware

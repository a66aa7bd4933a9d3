#include "firmware/events/event_printer.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

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
  print_untold();
}

void EventPrinter::run() {
  while (!done_.load()) {
    print_noted();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void EventPrinter::print_untold() {
  if (const std::uint64_t changes = lines_.take_untold(); changes > 0) {
    print_line(std::to_string(changes) + " more changes of settings");
  }
}

void EventPrinter::print_noted() {
  while (const std::optional<Event> event = events_.take()) {
    if (!lines_.take(*event)) {
      continue;
    }
    std::array<char, kMostLine> space;
    settings::PagedWriter line(space);
    describe(*event, line);
    if (event->kind == EventKind::kSettingsChanged) {
      print_untold();
    }
    print_line(line.text());
  }
}

}  // namespace stof::firmware

#include "firmware/events/event_printer.h"

#include <chrono>
#include <cstdio>
#include <optional>

#include "firmware/events/log_text.h"

namespace stof::firmware {

void print_line(const std::string& line) {
  std::printf("stofd: %s\n", line.c_str());
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
    print_line(describe(*event));
  }
}

}  // namespace stof::firmware

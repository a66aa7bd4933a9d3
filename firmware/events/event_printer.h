#pragma once

#include <atomic>
#include <string_view>
#include <thread>

#include "firmware/events/change_lines.h"
#include "firmware/events/events.h"

namespace stof::firmware {

// Prints what the loop notes, from a thread of its own: a terminal that blocks must not block the
// loop. The destructor prints the rest.
class EventPrinter {
 public:
  explicit EventPrinter(Events& events);
  ~EventPrinter();
  EventPrinter(const EventPrinter&) = delete;
  EventPrinter& operator=(const EventPrinter&) = delete;

 private:
  void run();
  void print_noted();
  void print_untold();

  Events& events_;
  ChangeLines lines_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

// One line on standard output, at once.
void print_line(std::string_view line);

}  // namespace stof::firmware

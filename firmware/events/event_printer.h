#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "firmware/events/events.h"

namespace stof::firmware {

// Prints what the loop notes, from a thread of its own: a terminal that blocks must not block the
// loop. The destructor prints the rest.
class Teller {
 public:
  explicit Teller(Events& events);
  ~Teller();
  Teller(const Teller&) = delete;
  Teller& operator=(const Teller&) = delete;

 private:
  void run();
  void tell();

  Events& events_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

// One line on standard output, at once.
void say(const std::string& line);

}  // namespace stof::firmware

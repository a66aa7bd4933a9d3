#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "firmware/control/control_server.h"
#include "firmware/control/cookie.h"
#include "hal/time.h"

namespace stof::firmware {

// This computer's time, also where the rig's is emulated: leases are of real seconds.
hal::Time control_now() noexcept;

// Random, for RequestHandler. Start-up only.
CookieSecret make_cookie_secret();

// The one thread beside the loop. Started before it; the destructor ends it, after a turn or two.
// Allocates at the start only.
class ControlThread {
 public:
  // Between the beginnings of two turns that answer. What comes meanwhile is answered together: in
  // a flood of 10,000 a second waking up and the tasks cost more than the answers.
  static constexpr hal::Duration kLeastTurn = std::chrono::milliseconds(2);

  explicit ControlThread(const ControlParts& parts);
  ~ControlThread();
  ControlThread(const ControlThread&) = delete;
  ControlThread& operator=(const ControlThread&) = delete;

 private:
  void run() noexcept;

  hal::Duration turn_;
  ControlServer control_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

}  // namespace stof::firmware

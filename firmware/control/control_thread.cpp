#include "firmware/control/control_thread.h"

#include <algorithm>
#include <chrono>
#include <random>

namespace stof::firmware {

hal::Time control_now() noexcept {
  return hal::Time(std::chrono::steady_clock::now().time_since_epoch());
}

CookieSecret make_cookie_secret() {
  CookieSecret secret{};
  std::random_device random;
  for (std::byte& byte : secret) {
    byte = static_cast<std::byte>(random());
  }
  return secret;
}

ControlThread::ControlThread(const ControlParts& parts)
    : turn_(parts.turn), control_(parts), thread_([this] { run(); }) {}

ControlThread::~ControlThread() {
  done_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void ControlThread::run() noexcept {
  hal::Time next{};
  while (!done_.load(std::memory_order_relaxed)) {
    if (control_.receive(turn_, &control_now) == Status::kDeviceLost) {
      std::this_thread::sleep_for(turn_);  // the tasks go on without the network
    }
    const hal::Time now = control_now();
    control_.tick(now);
    if (now < next) {
      std::this_thread::sleep_for(next - now);
    }
    next = std::max(now, next) + kLeastTurn;
  }
}

}  // namespace stof::firmware

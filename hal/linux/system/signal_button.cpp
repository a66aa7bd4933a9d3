#include "hal/linux/system/signal_button.h"

#include <atomic>
#include <csignal>
#include <cstdint>

#include <unistd.h>

#include "hal/linux/system/clock.h"

namespace stof::hal::linux {
namespace {

constexpr std::int64_t kPressMs = 300;
constexpr std::int64_t kHoldMs = 6000;
constexpr std::chrono::milliseconds kLetGo(1000);  // whoever looks may be busy

constinit std::atomic<std::int64_t> asked_ms{0};
static_assert(std::atomic<std::int64_t>::is_always_lock_free);  // a signal handler writes it

void press(int signal) {
  asked_ms.store(signal == SIGUSR1 ? kPressMs : kHoldMs, std::memory_order_relaxed);
}

}  // namespace

SignalButton::SignalButton() noexcept
    : SignalButton([]() noexcept -> Time { return Clock().now(); }) {}

SignalButton::SignalButton(Time (*now)() noexcept) noexcept : now_(now) {
  struct sigaction action{};
  action.sa_handler = &press;
  action.sa_flags = SA_RESTART;
  sigaction(SIGUSR1, &action, nullptr);
  sigaction(SIGUSR2, &action, nullptr);
}

Result<bool> SignalButton::pressed() noexcept {
  const Time now = now_();
  if (const std::int64_t ms = asked_ms.exchange(0, std::memory_order_relaxed); ms > 0) {
    from_ = now < until_ ? now + kLetGo : now;
    until_ = from_ + std::chrono::milliseconds(ms);
  }
  return now >= from_ && now < until_;
}

std::string SignalButton::usage() {
  const std::string own = std::to_string(::getpid());
  return "the button for pairing: kill -USR1 " + own + " presses it, kill -USR2 " + own +
         " holds it";
}

}  // namespace stof::hal::linux

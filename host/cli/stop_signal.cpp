#include "host/cli/stop_signal.h"

#include <csignal>

namespace stof::host {
namespace {

volatile std::sig_atomic_t g_stop = 0;  // NOLINT: what a signal handler may write

}  // namespace

void stop_on_signals() noexcept {
  struct sigaction action{};
  action.sa_handler = [](int /*signal*/) { g_stop = 1; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // The terminal was closed. nohup has it ignored, and goes on.
  struct sigaction former{};
  if (sigaction(SIGHUP, nullptr, &former) == 0 && former.sa_handler != SIG_IGN) {
    sigaction(SIGHUP, &action, nullptr);
  }
}

bool asked_to_stop() noexcept { return g_stop != 0; }

}  // namespace stof::host

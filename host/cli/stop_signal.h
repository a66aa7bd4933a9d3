#pragma once

// How a user ends a command that runs until then.
namespace stof::host {

// From now on SIGINT and SIGTERM do not end the program.
void stop_on_signals() noexcept;
// Whether one of them has come since.
bool asked_to_stop() noexcept;

}  // namespace stof::host

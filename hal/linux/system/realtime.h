#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace stof::hal::linux {

// Requests of a thread with deadlines to the system. A refusal is never fatal: it is a note, one
// line that says what, why and what to do. All of them may allocate and block: at start only.
using RealtimeNote = std::optional<std::string>;  // nothing: granted

// Keeps all memory of this process in RAM, also what it takes later.
RealtimeNote lock_memory();
// No core file of this process, and no look into it but by an administrator: it holds secrets.
void keep_memory_private() noexcept;
// Touches the calling thread's stack, so that later calls fault no page. At most 1 MiB counts.
void prefault_stack(std::size_t bytes = std::size_t{256} << 10) noexcept;
// SCHED_FIFO for the calling thread: 1 is least, 99 most. Threads that it starts meanwhile have it
// as well.
RealtimeNote set_fifo_priority(int priority);
// As ordinary threads are.
RealtimeNote set_ordinary_priority();

}  // namespace stof::hal::linux

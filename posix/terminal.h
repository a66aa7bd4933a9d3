#pragma once

#include <cstdint>
#include <expected>
#include <string>

#include "posix/fd.h"

// Serial lines and pseudo-terminals.
namespace stof::posix {

struct LineSettings {
  std::uint32_t baud = 115'200;
  bool flow_control = false;  // RTS and CTS
};

// A line whose reads and writes do not block, no controlling terminal; or an errno.
std::expected<Fd, int> open_line(const char* device) noexcept;
// Raw bytes, 8N1, no waiting for a carrier. 0 or an errno; EINVAL: the line does not make that
// speed within 3 percent.
int make_raw(int fd, const LineSettings& settings) noexcept;
// For this program alone. 0 or an errno.
int make_exclusive(int fd) noexcept;
// For all again. Before close(): a pseudo-terminal outlives it, and refuses all but the system's
// administrator until its far end closes too.
void end_exclusive(int fd) noexcept;
// Forgets what has not been sent or read: what waits would hold up close() until a silent peer
// takes it.
void discard_buffers(int fd) noexcept;

// Whether the line takes speeds without a name; qemu-user knows none.
bool has_any_speed(int fd) noexcept;
bool has_flow_control(int fd) noexcept;

// The far end of a line, which does not block either; name: the device that a program opens.
std::expected<Fd, int> open_pseudo_terminal(std::string& name);

}  // namespace stof::posix

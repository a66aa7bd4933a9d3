#include "hal/linux/system/restart.h"

#include <linux/reboot.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace stof::hal::linux {

Status restart_machine(const char* command) noexcept {
  ::sync();
  const unsigned what = *command == '\0' ? LINUX_REBOOT_CMD_RESTART : LINUX_REBOOT_CMD_RESTART2;
  static_cast<void>(::syscall(SYS_reboot, LINUX_REBOOT_MAGIC1, LINUX_REBOOT_MAGIC2, what, command));
  return Status::kDeviceError;
}

}  // namespace stof::hal::linux

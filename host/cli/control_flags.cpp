#include "host/cli/control_flags.h"

#include <limits>

namespace stof::host {

void add_device_flag(CLI::App& command, std::optional<std::uint32_t>& device) {
  // 0 means any sensor on the wire: who names a number means one.
  command
      .add_option("--device", device, "Number of the sensor (stofd --device): only it is believed")
      ->check(CLI::Range(1U, std::numeric_limits<std::uint32_t>::max()));
}

void add_control_flags(CLI::App& command, ControlFlags& flags) {
  command.add_option("--serial", flags.serial, "Serial line to the sensor, such as /dev/ttyUSB0");
  command.add_option("--baud", flags.baud, "Its speed, bit/s")
      ->check(CLI::Range(57'600U, 12'000'000U))
      ->capture_default_str();
  add_device_flag(command, flags.device);
  command.add_option("--key", flags.key,
                     "8 digits, of your key of the sensor: only whoever has it is believed");
  command.add_option("--keys", flags.keys,
                     "Your key file (default: ~/.config/stof/keys, or as XDG_CONFIG_HOME says)");
  command.add_option("--timeout", flags.timeout_s, "Seconds to wait for each of three attempts")
      ->check(CLI::Range(0.01, 60.0))
      ->capture_default_str();
}

}  // namespace stof::host

#include "board/serial_lines.h"

#include <gtest/gtest.h>

namespace stof::board {
namespace {

TEST(SerialLines, AreLinesAndNothingElse) {
  for (const char* const line : {"", "/dev/ttyAMA0", "/dev/ttyS1", "/dev/ttyUSB12", "/dev/ttyACM0",
                                 "/dev/serial/by-id/usb-FTDI_x-if00", "/dev/serial/by-path/p"}) {
    EXPECT_TRUE(takes_serial_line(line)) << line;
  }
  for (const char* const other :
       {"/dev/watchdog0", "/dev/watchdog", "/dev/mem", "/dev/tty", "/dev/tty1", "/dev/pts/0",
        "/dev/ttyS", "/dev/ttyS0/../watchdog0", "/dev/serial/by-id/../../watchdog0",
        "/dev/serial/by-id/", "/etc/passwd", "ttyS0", "/dev/nope"}) {
    EXPECT_FALSE(takes_serial_line(other)) << other;
  }
}

}  // namespace
}  // namespace stof::board

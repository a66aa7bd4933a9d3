#include "hal/linux/system/watchdog.h"

#include <cerrno>
#include <chrono>
#include <cstdarg>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>

#include "hal/emu/devices/clock.h"
#include "hal/emu/devices/watchdog.h"

namespace {

// A driver behind any file; the linker sends ioctl here (--wrap).
struct Driver {
  bool is_watchdog = true;
  bool can_stop = true;
  bool deaf = false;
  int timeout = 0;  // seconds
  int kicks = 0;
};
Driver driver;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): ioctl reads it

}  // namespace

extern "C" int __wrap_ioctl(int fd, unsigned long request, ...);  // NOLINT: its own type

extern "C" int __wrap_ioctl(int fd, unsigned long request, ...) {  // NOLINT: its own type
  va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  if (fd < 0 || !driver.is_watchdog || driver.deaf) {
    errno = driver.deaf ? EIO : ENOTTY;
    return -1;
  }
  if (request == WDIOC_SETTIMEOUT) {
    int& seconds = *static_cast<int*>(argument);
    seconds = (seconds + 3) / 4 * 4;  // counts in fours
    driver.timeout = seconds;
    return 0;
  }
  if (request == WDIOC_GETSUPPORT) {
    static_cast<watchdog_info*>(argument)->options = driver.can_stop ? WDIOF_MAGICCLOSE : 0;
    return 0;
  }
  driver.kicks += request == WDIOC_KEEPALIVE ? 1 : 0;
  return 0;
}

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::linux::WatchdogDevice;

class WatchdogTest : public testing::Test {
 protected:
  WatchdogTest() {
    driver = {};
    std::string pattern = (std::filesystem::temp_directory_path() / "stof-dog-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    std::ofstream(device()) << "";
  }
  ~WatchdogTest() override { std::filesystem::remove_all(folder_); }

  std::string device() const { return folder_ + "/watchdog0"; }
  std::string written() const {
    std::stringstream text;
    text << std::ifstream(device()).rdbuf();
    return text.str();
  }

 private:
  std::string folder_;
};

TEST_F(WatchdogTest, TakesTheTimeThatTheDriverMakesOfIt) {
  const auto dog = WatchdogDevice::open({.device = device(), .timeout = 10s});
  ASSERT_TRUE(dog) << dog.error().message;
  EXPECT_EQ((*dog)->timeout(), 12s);
  EXPECT_EQ((*dog)->kick(), Status::kOk);
  EXPECT_EQ((*dog)->kick(), Status::kOk);
  EXPECT_EQ(driver.kicks, 2);
  driver.deaf = true;
  EXPECT_EQ((*dog)->kick(), Status::kDeviceError);
}

TEST_F(WatchdogTest, StopsOnlyWhenAskedTo) {
  {
    EXPECT_TRUE(WatchdogDevice::open({.device = device()}));
  }
  EXPECT_EQ(written(), "") << "it runs on";
  const auto dog = WatchdogDevice::open({.device = device()});
  ASSERT_TRUE(dog);
  EXPECT_EQ((*dog)->disarm(), Status::kOk);
  EXPECT_EQ(written(), "V");
  EXPECT_EQ((*dog)->disarm(), Status::kOk);
  EXPECT_EQ((*dog)->kick(), Status::kDeviceError);
}

TEST_F(WatchdogTest, DriverThatCannotStopSaysSo) {
  driver.can_stop = false;
  const auto dog = WatchdogDevice::open({.device = device()});
  ASSERT_TRUE(dog);
  EXPECT_EQ((*dog)->disarm(), Status::kUnsupported);
  EXPECT_EQ((*dog)->kick(), Status::kOk);
}

TEST_F(WatchdogTest, SaysInOneLineWhyItDoesNotOpen) {
  const auto message = [](const hal::linux::WatchdogOptions& options) {
    const auto dog = WatchdogDevice::open(options);
    EXPECT_FALSE(dog);
    return dog ? std::string() : dog.error().message;
  };
  EXPECT_NE(message({.device = device() + "1"}).find("load the driver"), std::string::npos);
  EXPECT_NE(message({.device = device(), .timeout = 0s}).find("choose another"), std::string::npos);
  driver.is_watchdog = false;
  EXPECT_NE(message({.device = device()}).find("name of a watchdog"), std::string::npos);
  EXPECT_EQ(written(), "") << "a file that is no watchdog stays as it is";
}

TEST(EmuWatchdog, BitesWhenNobodyKicksInTime) {
  hal::emu::Clock clock;
  hal::emu::Watchdog dog(clock, 1s);
  for (int i = 0; i < 10; ++i) {
    clock.wait_until(clock.now() + 1s);
    EXPECT_EQ(dog.kick(), Status::kOk);
  }
  EXPECT_EQ(dog.kicks(), 10U);
  EXPECT_FALSE(dog.expired());
  clock.wait_until(clock.now() + 1s + 1ns);
  EXPECT_TRUE(dog.expired());
  EXPECT_EQ(dog.kick(), Status::kDeviceError);
  EXPECT_TRUE(dog.expired()) << "a late kick helps nothing";
  EXPECT_EQ(dog.disarm(), Status::kDeviceError);
}

TEST(EmuWatchdog, DoesNotBiteAfterAnOrderlyEnd) {
  hal::emu::Clock clock;
  hal::emu::Watchdog dog(clock, 1s);
  EXPECT_EQ(dog.disarm(), Status::kOk);
  clock.wait_until(clock.now() + 1h);
  EXPECT_FALSE(dog.expired());
  EXPECT_FALSE(dog.armed());
}

}  // namespace
}  // namespace stof::test

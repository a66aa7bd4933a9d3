#include <array>
#include <atomic>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include "hal/framing/cobs.h"
#include "host/cli/config/config.h"
#include "host/cli/failure.h"
#include "host/client/serial/serial_line.h"
#include "tests/host/cli/sensor_stub.h"
#include "tests/support/pty.h"

namespace stof::host {
namespace {

// The sensor's end of a serial line: answers, with noise and empty frames between.
class SerialSensor {
 public:
  SerialSensor() {
    static_cast<void>(pty_.open());
    thread_ = std::thread([this] { run(); });
  }
  ~SerialSensor() {
    done_ = true;
    thread_.join();
  }
  SerialSensor(const SerialSensor&) = delete;
  SerialSensor& operator=(const SerialSensor&) = delete;
  const std::string& name() const { return pty_.name(); }

 private:
  void run() {
    std::array<std::byte, 1024> space{};
    while (!done_) {
      pollfd asked{.fd = pty_.fd(), .events = POLLIN, .revents = 0};
      ::poll(&asked, 1, 10);
      const ssize_t got = ::read(pty_.fd(), space.data(), space.size());
      std::span<const std::byte> bytes =
          std::span(space).first(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      while (const auto frame = reader_.take(bytes)) {
        if (const auto answer = sensor_.answer(*frame)) {
          reply(*answer);
        }
      }
    }
  }

  void reply(std::span<const std::byte> packet) {
    std::array<std::byte, 1400> out{};
    out[0] = std::byte{0x55};  // noise
    out[2] = std::byte{0xAA};
    const std::size_t bytes = 4 + hal::cobs_encode(packet, std::span(out).subspan(4)) + 1;
    std::size_t sent = 0;
    while (sent < bytes && !done_) {
      const ssize_t taken = ::write(pty_.fd(), out.data() + sent, bytes - sent);
      sent += static_cast<std::size_t>(std::max<ssize_t>(taken, 0));
    }
  }

  test::Pty pty_;
  SensorStub sensor_;
  hal::CobsReader reader_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

TEST(ConfigOverSerial, ReadsAndChangesSettings) {
  const SerialSensor sensor;
  if (sensor.name().empty()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  const auto run = [&sensor](const std::vector<std::string>& words) {
    auto line = client::open_serial_transport(sensor.name(), 921'600);
    EXPECT_TRUE(line) << (line ? "" : line.error().message);
    return config_over(std::move(*line), words, {{.timeout_s = 5}});
  };
  EXPECT_EQ(run({"get", "name"}), "stof\n");
  EXPECT_EQ(run({"set", "name=arm"}),
            "revision 2, in force, until the next start: save keeps it\n");
  EXPECT_EQ(run({"get", "name"}), "arm\n");
  EXPECT_GT(run({"schema"}).size(), 5000U);
}

TEST(ConfigOverSerial, SaysWhatIsNoLine) {
  for (const char* const name : {"/dev/none", "/dev/null"}) {
    const auto line = client::open_serial_transport(name, 921'600);
    ASSERT_FALSE(line);
    EXPECT_EQ(line.error().message.find(name), 0U) << line.error().message;
    EXPECT_EQ(line.error().message.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace stof::host

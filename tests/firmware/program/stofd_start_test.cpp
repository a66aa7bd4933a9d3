#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "firmware/records/record_disk.h"
#include "firmware/wire/keys/key_table.h"
#include "firmware/wire/keys/key_text.h"
#include "firmware/wire/messages/conditions.h"
#include "firmware/wire/messages/health.h"
#include "firmware/wire/packet.h"
#include "hal/linux/system/file_disk.h"
#include "posix/udp_socket.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/firmware/program/stofd_process.h"

// What was saved never keeps the program from starting; it ends and changes when it is told to.
namespace stof::firmware::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

const std::vector<std::string> kSmall{"--size", "64x50", "--pmd", "32x24", "--disparities", "16"};

std::vector<std::string> small(const std::vector<std::string>& more) {
  std::vector<std::string> all = kSmall;
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

class StofdStart : public ::testing::Test {
 protected:
  StofdStart() {
    std::string name = (fs::temp_directory_path() / "stofd_start_XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~StofdStart() override { fs::remove_all(dir_); }

  std::string path(const std::string& name) const { return (dir_ / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(dir_ / name, std::ios::binary) << text;
  }
  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(dir_ / name, std::ios::binary).rdbuf();
    return text.str();
  }
  std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(dir_)) {
      names.push_back(entry.path().filename().string());
    }
    std::ranges::sort(names);
    return names;
  }
  // Publishes and ends well, and says so.
  void expect_starts(const std::string& name, const std::string& told, bool any_port = true,
                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments =
        small({"--settings", path(name), "--frames", "2", "--free-run"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = run_stofd(arguments, any_port);
    EXPECT_EQ(ended.code, 0) << name << ": " << ended.error;
    EXPECT_EQ(ended.error, "") << name;
    EXPECT_NE(ended.out.find(told), std::string::npos) << name << ": " << ended.out;
    EXPECT_NE(ended.out.find("2 frames published"), std::string::npos) << name << ": " << ended.out;
  }

  fs::path dir_;
};

// Waits for a health message whose condition is active; none within a minute.
std::optional<wire::HealthReport> hear_health(const Socket& socket, std::uint32_t bits) {
  const auto end = Clock::now() + 60s;
  while (Clock::now() < end) {
    const std::vector<std::byte> bytes = socket.receive();
    const auto packet = wire::parse_packet(bytes);
    if (packet && packet->header.type == wire::PacketType::kHealth) {
      const auto health = wire::decode_health_report(packet->payload);
      if (health && (health->active & bits) == bits) {
        return *health;
      }
    }
  }
  return std::nullopt;
}

std::uint32_t bit(wire::Condition condition) { return 1U << static_cast<unsigned>(condition); }

TEST_F(StofdStart, NothingThatWasSavedKeepsItFromStarting) {
  const std::vector<std::pair<std::string, std::string>> saved{
      {R"({"serial": {"device": "/dev/nope", "mode": "stof"}})", "has no line /dev/nope"},
      {R"({"serial": {"device": "/dev/watchdog0"}})", "has no line /dev/watchdog0"},
      {R"({"serial": {"device": "/dev/pts/0"}})", "has no line /dev/pts/0"},
      {R"({"serial": {"device": "/dev/ttyS99", "mode": "stof"}})", "waiting for the serial line"},
      {"", "empty: the defaults hold"},
      {"{", "not JSON: it ends too early: the defaults hold, the file is kept as .bad"},
      {R"({"depth": {"disparities": 256}})", "256 disparities are more than the 128 of board emu"},
      {R"({"period_ms": 1})", "period_ms"},
      {R"({"depth": {"match": {"block": "255x255"}}})", "the defaults hold"},
      {std::string(100'000, '{'), "the defaults hold"}};
  for (const auto& [text, told] : saved) {
    write("settings.json", text);
    expect_starts("settings.json", told, true,
                  told.starts_with("256") ? std::vector<std::string>{"--disparities", "0"}
                                          : std::vector<std::string>{});
  }
}

// The image keeps everything there.
TEST_F(StofdStart, SettingsAndKeysAreKeptOnAPartitionWithoutFiles) {
  using records::Document;
  write("disk", "");
  fs::resize_file(dir_ / "disk", records::kRecordsBytes);
  const auto disk = hal::linux::FileDisk::open(path("disk"));
  ASSERT_TRUE(disk);
  records::RecordDisk records(**disk);
  const auto bytes = [](std::string_view text) { return std::as_bytes(std::span(text)); };
  ASSERT_EQ(records.save(Document::kSettings, bytes("{")), Status::kOk);
  ASSERT_EQ(records.save(Document::kKeys, bytes("no keys")), Status::kOk);
  const Ended ended =
      run_stofd(small({"--records", path("disk"), "--frames", "2", "--free-run"}), true);
  EXPECT_EQ(ended.code, 0) << ended.error;
  for (const char* const told : {"disk: not JSON", "no key file, or damaged", "2 frames"}) {
    EXPECT_NE(ended.out.find(told), std::string::npos) << told << ": " << ended.out;
  }
  std::array<std::byte, 16> space{};
  EXPECT_EQ(records.load(Document::kSettings, space).value(), std::nullopt);
  EXPECT_EQ(records.load(Document::kDamagedSettings, space).value(), 1);
  EXPECT_EQ(entries(), std::vector<std::string>{"disk"});
}

// Whatever is erased, and whatever size the disk gets: a sensor that has keys never starts open.
TEST_F(StofdStart, KeysThatAreErasedOrOfAnotherDisksSizeAreNotMissing) {
  using records::Document;
  write("disk", "");
  fs::resize_file(dir_ / "disk", records::kRecordsBytes);
  {
    const auto disk = hal::linux::FileDisk::open(path("disk"));
    ASSERT_TRUE(disk);
    records::RecordDisk records(**disk);
    const auto save = [&records](Document document, std::string_view text) {
      ASSERT_EQ(records.save(document, std::as_bytes(std::span(text))), Status::kOk);
    };
    save(Document::kSettings, R"({"limits": {"streams": "fixed"}})");
    wire::KeyTable keys;
    ASSERT_EQ(keys.add(stof::test::numbered_key(7)), Status::kOk);
    std::array<char, wire::kMostKeyText> space{};
    const std::span<char> text = wire::write_keys(keys, space);
    save(Document::kKeys, {text.data(), text.size()});
  }
  const auto hear = [this](std::uint32_t bits, const std::vector<std::string>& lines) {
    const Socket socket;
    const Stofd stofd(small({"--records", path("disk"), "--to", socket.destination}));
    const auto health = hear_health(socket, bits);
    stofd.signal(SIGTERM);
    const Ended ended = stofd.end();
    EXPECT_EQ(ended.code, 0) << ended.error;
    for (const std::string& told : lines) {
      EXPECT_NE(ended.out.find(told), std::string::npos) << ended.out;
    }
    return health;
  };
  const std::uint32_t open = bit(wire::Condition::kUnpaired) | bit(wire::Condition::kKeysLost);
  fs::resize_file(dir_ / "disk", records::kRecordsBytes + records::kEraseBlockBytes);
  const auto keyed = hear(0, {"its size has changed"});
  ASSERT_TRUE(keyed);
  EXPECT_EQ(keyed->active & open, 0U);
  fs::resize_file(dir_ / "disk", records::kRecordsBytes);
  {
    const auto disk = hal::linux::FileDisk::open(path("disk"));
    const std::vector<std::byte> page(4096);
    for (const std::size_t area : {std::size_t{0}, records::kBetweenAreas}) {
      for (const Document document : {Document::kKeys, Document::kSettings, Document::kLimits}) {
        ASSERT_EQ((*disk)->write(area + records::kPlaces[number(document)], page), Status::kOk);
      }
    }
  }
  const auto health = hear(bit(wire::Condition::kKeysLost),
                           {"lost, damaged or older than it was: settings, limits, keys: ",
                            "with the strictest limits"});
  ASSERT_TRUE(health);
  EXPECT_TRUE(health->active & bit(wire::Condition::kSettingsDropped));
  // Of the first area alone, without its directory, the keys' place is left.
  fs::resize_file(dir_ / "disk", records::kPlaces[number(Document::kCalibration)]);
  EXPECT_TRUE(hear(bit(wire::Condition::kKeysLost), {"it has become smaller"}));
  fs::resize_file(dir_ / "disk", 100);
  EXPECT_EQ(run_stofd(small({"--records", path("disk")})).code, 2)
      << "there is nothing to start from";
}

TEST_F(StofdStart, TwoOnOneFileAreToldAndTheSecondEndsWithCodeOne) {
  write("disk", "");
  fs::resize_file(dir_ / "disk", records::kRecordsBytes);
  for (const std::vector<std::string>& files : {std::vector<std::string>{"--records", path("disk")},
                                                {"--settings", path("settings.json")},
                                                {"--keys", path("keys")}}) {
    const Socket socket;
    std::vector<std::string> running = files;
    running.insert(running.end(), {"--to", socket.destination});
    const Stofd first(small(running));
    EXPECT_TRUE(hear_health(socket, 0));
    std::vector<std::string> more = files;
    more.insert(more.end(), {"--frames", "2", "--free-run"});
    const Ended second = run_stofd(small(more));
    EXPECT_EQ(second.code, 1) << files.front();
    EXPECT_NE(second.error.find("another stofd"), std::string::npos) << second.error;
    EXPECT_EQ(std::ranges::count(second.error, '\n'), 1) << second.error;
    first.signal(SIGKILL);  // and at once the next one
    const Ended next = run_stofd(small(more));
    EXPECT_EQ(next.code, 0) << files.front() << next.error;
    first.end();
  }
}

TEST_F(StofdStart, APortThatIsTakenIsReplaced) {
  const posix::UdpSocket other(AF_INET6);
  ASSERT_EQ(other.bind(posix::make_address(in6_addr{}, 0)), 0);
  write("settings.json", "{\"udp\": {\"port\": " + std::to_string(other.port()) + "}}");
  expect_starts("settings.json", "UDP port " + std::to_string(other.port()) + ": ", false);
  // Who names it on the command line is told.
  const Ended ended = run_stofd(small({"--port", std::to_string(other.port())}), false);
  EXPECT_EQ(ended.code, 2);
  EXPECT_EQ(std::ranges::count(ended.error, '\n'), 1) << ended.error;
}

TEST_F(StofdStart, ALineOfTheCommandLineThatIsNoneEndsItWithCodeTwo) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--serial", "/dev/nope"},
                                                {"--to", "127.0.0.1:9", "--to", "127.0.0.1:10"},
                                                {"--device", "0"},
                                                {"--to", "255.255.255.255:9"},
                                                {"--to", "127.255.255.255:9"}}) {
    const Ended ended = run_stofd(small(wrong));
    EXPECT_EQ(ended.code, 2) << wrong.back();
    EXPECT_EQ(std::ranges::count(ended.error, '\n'), 1) << ended.error;
  }
}

TEST_F(StofdStart, WhatIsNoRegularFileIsLeftAlone) {
  fs::create_directory(dir_ / "folder");
  write("target", "kept");
  fs::create_symlink(dir_ / "target", dir_ / "link");
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);  // whoever opens it waits for ever
  const std::vector<std::string> before = entries();
  for (const char* const name : {"folder", "link", "pipe"}) {
    expect_starts(name, "no regular file, it is left alone: the defaults hold");
  }
  // Keys could be kept beside it: of these alone there is a lock.
  std::vector<std::string> after = entries();
  std::erase_if(after, [](const std::string& name) { return name.ends_with(".keys.lock"); });
  EXPECT_EQ(after, before);
  EXPECT_TRUE(fs::is_directory(dir_ / "folder"));
  EXPECT_EQ(read("target"), "kept");
  expect_starts("/../../../../../../../../../dev/null", "no regular file");
  struct stat device{};
  ASSERT_EQ(lstat("/dev/null", &device), 0);
  EXPECT_TRUE(S_ISCHR(device.st_mode));
}

// Two starts that were reset before they had proven new settings.
TEST_F(StofdStart, TwoFailedStartsBringTheLastGoodSettingsBack) {
  write("settings.json", R"({"name": "new"})");
  write("settings.json.good", R"({"name": "good"})");
  for (int i = 0; i < 2; ++i) {
    const Stofd stofd(small({"--settings", path("settings.json")}));
    for (int k = 0; k < 6000 &&
                    read("settings.json.trial").find(std::to_string(i + 1), 8) == std::string::npos;
         ++k) {
      usleep(10'000);
    }
    stofd.signal(SIGKILL);
    stofd.end();
  }
  for (int i = 0; i < 2; ++i) {
    expect_starts("settings.json",
                  "two starts with these settings have failed: the last good settings hold");
  }
  EXPECT_EQ(read("settings.json"), R"({"name": "new"})") << "it stays until the next save";
  write("settings.json", R"({"name": "newer"})");
  const Ended ended =
      run_stofd(small({"--settings", path("settings.json"), "--frames", "2", "--free-run"}));
  EXPECT_EQ(ended.out.find("last good"), std::string::npos) << ended.out;
}

TEST_F(StofdStart, ACommandLineThatIsRefusedIsNoFailedStart) {
  write("settings.json", R"({"name": "new"})");
  write("rig.cal", "none");
  for (int i = 0; i < 4; ++i) {
    const auto more = i % 2 == 0 ? std::vector<std::string>{"--threads", "99"}
                                 : std::vector<std::string>{"--calibration", path("rig.cal")};
    std::vector<std::string> words = {"--settings", path("settings.json")};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run_stofd(small(words)).code, 2);
  }
  const Ended ended =
      run_stofd(small({"--settings", path("settings.json"), "--frames", "2", "--free-run"}));
  EXPECT_EQ(ended.out.find("have failed"), std::string::npos) << ended.out;
}

TEST_F(StofdStart, WhatWasDroppedIsACondition) {
  write("settings.json", R"({"serial": {"device": "/dev/nope"}, "depth": {"max_range_mm": 500}})");
  const Socket socket;
  const Stofd stofd(small({"--settings", path("settings.json"), "--to", socket.destination}));
  EXPECT_TRUE(hear_health(
      socket, bit(wire::Condition::kConnectionReplaced) | bit(wire::Condition::kNoDepth)));
  stofd.signal(SIGTERM);
  EXPECT_EQ(stofd.end().code, 0);
  fs::create_directory(dir_ / "folder");
  const Stofd other(small({"--settings", path("folder"), "--to", socket.destination}));
  EXPECT_TRUE(hear_health(socket, bit(wire::Condition::kSettingsDropped)));
  other.signal(SIGTERM);
  EXPECT_EQ(other.end().code, 0);
}

// Keys that cannot be reached are not the same as none.
TEST_F(StofdStart, KeysInAFolderThatIsMissingAreLost) {
  write("file", "");
  for (const char* const keys : {"missing/keys", "file/keys", "keys"}) {
    const Socket socket;
    const Stofd stofd(small({"--keys", path(keys), "--to", socket.destination}));
    EXPECT_TRUE(hear_health(socket, bit(std::string(keys) == "keys" ? wire::Condition::kUnpaired
                                                                    : wire::Condition::kKeysLost)))
        << keys;
    stofd.signal(SIGTERM);
    EXPECT_EQ(stofd.end().code, 0);
  }
}

TEST_F(StofdStart, EachDocumentHasAFileOfItsOwn) {
  write("label", "000102030405060708090a0b0c0d0e0f");
  write("zeros", std::string(32, '0'));
  fs::create_directory(dir_ / "sub");
  const std::string settings = path("settings.json");
  const std::vector<std::vector<std::string>> clashes{
      {"--settings", settings, "--keys", settings},
      {"--settings", settings, "--keys", path("sub/../settings.json.good")},
      {"--settings", settings, "--keys", settings + ".trial"},
      {"--settings", settings, "--keys", settings + ".limits"},
      {"--label", path("label"), "--keys", path("label")},
      {"--keys", path("keys"), "--port-file", path("keys")},
      {"--settings", settings, "--port-file", settings + ".good"},
      {"--label", path("zeros")}};
  for (const auto& arguments : clashes) {
    const Ended ended = run_stofd(small(arguments));
    EXPECT_EQ(ended.code, 2) << arguments.back();
    EXPECT_EQ(std::ranges::count(ended.error, '\n'), 1) << ended.error;
  }
}

TEST_F(StofdStart, SecretsThatOthersCouldReadAreTold) {
  write("keys", "stof keys 1\ncrc32c 00000000\n");
  write("label", "000102030405060708090a0b0c0d0e0f");
  const std::vector<std::string> arguments =
      small({"--keys", path("keys"), "--label", path("label"), "--frames", "2", "--free-run"});
  for (const auto& [mode, told] : {std::pair(0644, true), std::pair(0600, false)}) {
    ASSERT_EQ(chmod(path("keys").c_str(), static_cast<mode_t>(mode)), 0);
    ASSERT_EQ(chmod(path("label").c_str(), static_cast<mode_t>(mode)), 0);
    const Ended ended = run_stofd(arguments);
    EXPECT_EQ(ended.code, 0) << ended.error;
    for (const char* const what : {"keys: others than its owner", "label: others than its owner"}) {
      EXPECT_EQ(ended.out.find(what) != std::string::npos, told) << ended.out;
    }
  }
}

// That it looks within 100 ms whether it shall end: Appliance.HealthComesOnceASecondAtAnyPeriod, by
// an emulated clock.
TEST_F(StofdStart, EndsAndTellsItsHealthLongBeforeItsNextEdge) {
  write("settings.json", R"({"period_ms": 60000})");
  const Socket socket;
  const Clock::time_point started = Clock::now();
  const Stofd stofd(small({"--settings", path("settings.json"), "--to", socket.destination}));
  const auto first = hear_health(socket, 0);
  const auto second = hear_health(socket, 0);
  const auto third = hear_health(socket, 0);
  ASSERT_TRUE(first && second && third);
  EXPECT_LT(third->uptime_ms, 30'000U);
  stofd.signal(SIGTERM);
  EXPECT_EQ(stofd.end().code, 0);
  EXPECT_LE(Clock::now() - started, 50s) << "it waited for an edge";
}

}  // namespace
}  // namespace stof::firmware::test

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/frame/frame_coder.h"
#include "firmware/wire/packet.h"
#include "tests/firmware/program/stofd_process.h"

// The program with several threads, as its users start it.
namespace stof::firmware::test {
namespace {

const std::vector<std::string> kSmallCorridor{"--scene", "corridor", "--size",        "64x50",
                                              "--pmd",   "32x24",    "--disparities", "16"};

std::vector<std::string> with(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// What it says at the start.
std::string greeting(const std::vector<std::string>& arguments) {
  const Ended ended = run_stofd(with(arguments, {"--frames", "1", "--free-run"}));
  EXPECT_EQ(ended.code, 0) << ended.error;
  EXPECT_EQ(ended.error, "");
  const std::size_t end = ended.out.find('\n', ended.out.find("workspace"));
  return ended.out.substr(0, end);
}

TEST(StofdThreads, BadNumbersEndInOneLineAndCodeTwo) {
  const std::vector<std::vector<std::string>> wrong{
      {"--threads", "9"}, {"--threads", "-1"},           {"--threads", "x"},
      {"--threads", ""},  {"--threads", "1.5"},          {"--threads", "256"},
      {"--threads"},      {"--set", "compute.threads=9"}};
  for (const std::vector<std::string>& arguments : wrong) {
    const Ended ended = run_stofd(arguments);
    const std::string all = arguments.front() + " " + arguments.back();
    EXPECT_EQ(ended.code, 2) << all;
    EXPECT_EQ(ended.out, "") << all;
    EXPECT_TRUE(ended.error.starts_with("stofd: " + arguments.front())) << ended.error;
    EXPECT_EQ(std::ranges::count(ended.error, '\n'), 1) << ended.error;
  }
  EXPECT_EQ(run_stofd({"--threads", "9"}).error,
            "stofd: --threads: compute.threads: takes 0 to 8, not \"9\"\n");
}

TEST(StofdThreads, GreetingTellsHowManyCompute) {
  for (const auto& [asked, told] :
       {std::pair{"1", " KiB, 1 thread"}, {"2", " KiB, 2 threads"}, {"8", " KiB, 8 threads"}}) {
    EXPECT_TRUE(greeting(with(kSmallCorridor, {"--threads", asked})).ends_with(told)) << asked;
  }
  for (const auto& more : {std::vector<std::string>{}, {"--threads", "0"}}) {
    const std::string line = greeting(with(kSmallCorridor, more));
    const int threads = line[line.rfind("KiB, ") + 5] - '0';
    EXPECT_GE(threads, 1) << line;
    EXPECT_LE(threads, 4) << line;
  }
}

// A dataset of flat pictures as large as the board takes them.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "stofd_test_XXXXXX").string();
    path_ = mkdtemp(name.data());
    const std::string picture = "P5\n1280 720\n255\n" + std::string(1280UL * 720, 'x');
    std::ofstream(path_ / "left.pgm", std::ios::binary) << picture;
    std::ofstream(path_ / "right.pgm", std::ios::binary) << picture;
    std::ofstream(path_ / "meta.txt") << "scene flat\nndisp 128\n";
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string name() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

// They leave no memory for many searches.
TEST(StofdThreads, FewerComputeWhereMemoryIsShort) {
  const Folder flat;
  const std::string line =
      greeting({"--dataset", flat.name(), "--preset", "quality", "--threads", "8"});
  EXPECT_TRUE(line.ends_with(" (of 8: there is no memory for more searches)")) << line;
}

// Tiles of the first whole frame, one after the other.
std::vector<std::byte> first_frame(const std::string& threads) {
  const Socket socket;
  // In emulated time: on a busy computer a camera misses its frame else, and depth is another one.
  const Stofd stofd(with(kSmallCorridor, {"--threads", threads, "--to", socket.destination,
                                          "--frames", "1", "--free-run"}));
  std::vector<std::byte> tiles;
  int left = -1;
  while (left != 0) {
    const std::vector<std::byte> datagram = socket.receive();
    const auto packet = wire::parse_packet(datagram);
    if (!packet) {
      ADD_FAILURE() << "no packet";
      break;
    }
    const bool info = packet->header.type == wire::PacketType::kFrameInfo;
    if (info && packet->header.frame.number == 0) {
      left = packet->header.count;
    }
    left -= left > 0 && (info || packet->header.type == wire::PacketType::kTile) ? 1 : 0;
    if (packet->header.type == wire::PacketType::kTile && packet->header.frame.number == 0) {
      tiles.insert(tiles.end(), packet->payload.begin(), packet->payload.end());
    }
  }
  EXPECT_EQ(stofd.end().code, 0);
  return tiles;
}

TEST(StofdThreads, AnyNumberSendsTheSameDepth) {
  const std::vector<std::byte> alone = first_frame("1");
  EXPECT_GT(alone.size(), 500U);
  for (const char* const threads : {"2", "3", "8"}) {
    EXPECT_TRUE(first_frame(threads) == alone) << threads;
  }
}

}  // namespace
}  // namespace stof::firmware::test

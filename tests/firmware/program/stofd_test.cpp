#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "firmware/wire/calibration/calibration_file.h"
#include "firmware/wire/calibration/calibration_packet.h"
#include "firmware/wire/packet.h"
#include "tests/firmware/program/stofd_process.h"

// The program as its users start it.
namespace stof::firmware::test {
namespace {

namespace fs = std::filesystem;

// One line that says what is wrong, nothing else, exit code 2.
void expect_refused(const std::vector<std::string>& arguments, const std::string& about) {
  std::string all;
  for (const std::string& argument : arguments) {
    all += argument + " ";
  }
  SCOPED_TRACE(all);
  const Ended ended = run_stofd(arguments);
  EXPECT_EQ(ended.code, 2) << ended.error;
  EXPECT_EQ(ended.out, "");
  EXPECT_EQ(ended.error.substr(0, 7), "stofd: ");
  EXPECT_EQ(std::ranges::count(ended.error, '\n'), 1) << ended.error;
  EXPECT_TRUE(ended.error.ends_with('\n'));
  EXPECT_NE(ended.error.find(about), std::string::npos) << ended.error;
}

class StofdTest : public ::testing::Test {
 protected:
  StofdTest() {
    std::string name = (fs::temp_directory_path() / "stofd_test_XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~StofdTest() override { fs::remove_all(dir_); }

  std::string path(const std::string& name) const { return (dir_ / name).string(); }
  void write(const std::string& name, const std::string& bytes) const {
    fs::create_directories((dir_ / name).parent_path());
    std::ofstream(dir_ / name, std::ios::binary) << bytes;
  }
  static std::string pgm(int width, int height, int step = 7) {
    std::string bytes = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
    for (int i = 0; i < width * height; ++i) {
      bytes.push_back(static_cast<char>(i * i * step >> 3));
    }
    return bytes;
  }
  // A dataset without truth and PMD recording; returns its folder.
  std::string dataset(const std::string& name, int width = 48, int height = 32,
                      int ndisp = 8) const {
    write(name + "/left.pgm", pgm(width, height));
    write(name + "/right.pgm", pgm(width, height));
    write(name + "/meta.txt", "scene " + name + "\nndisp " + std::to_string(ndisp) + "\n");
    return path(name);
  }

  fs::path dir_;
};

// Blocks that an earlier version matched: one line, and the sensor runs.
TEST_F(StofdTest, StartsWithBlocksWhoseSumsDoNotFit) {
  write("saved.json", R"({"depth": {"preset": "quality", "match": {"prefilter": 31}}})");
  const std::string fallback = "depth.match.prefilter: sums of such blocks do not fit 16 bits";
  for (const std::vector<std::string>& how : std::vector<std::vector<std::string>>{
           {"--prefilter", "31"}, {"--settings", path("saved.json"), "--preset", "fast"}}) {
    std::vector<std::string> all{"--frames", "1", "--free-run", "--size", "160x120", "--port", "0"};
    all.insert(all.end(), how.begin(), how.end());
    const Ended ended = run_stofd(all);
    EXPECT_EQ(ended.code, 0) << ended.error;
    EXPECT_NE((ended.out + ended.error).find(fallback), std::string::npos) << ended.error;
  }
  const Ended left = run_stofd({"--frames", "1", "--free-run", "--size", "160x120", "--port", "0",
                                "--set", "depth.match.method=sgm"});
  EXPECT_EQ(left.code, 0) << left.error;
  EXPECT_NE((left.out + left.error).find("depth.match.method: not in this version"),
            std::string::npos);
}

TEST_F(StofdTest, HelpNamesEveryFlagAndTheExitCodes) {
  const Ended ended = run_stofd({"--help"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(ended.error, "");
  for (const char* const word :
       {"--frames", "--period-ms", "--calibration", "--disparities", "--block", "--lr", "--preset",
        "--subpixel", "--to", "--scene", "--dataset", "--tof", "--truth", "--free-run", "--fault",
        "Exit codes", "1..256; 0 (default): what the rig asks for"}) {
    EXPECT_NE(ended.out.find(word), std::string::npos) << word;
  }
}

TEST_F(StofdTest, BadFlagsEndInOneLineAndCodeTwo) {
  expect_refused({"--bogus"}, "--bogus");
  expect_refused({"cones"}, "cones");
  for (const char* const value : {"0", "-1", "abc", "", "1x", "99999999999999999999"}) {
    expect_refused({"--frames", value}, "--frames");
  }
  expect_refused({"--frames"}, "--frames");
  for (const char* const value : {"16", "0x16", "16x65", "x", "16x16x16", "16,16"}) {
    expect_refused({"--block", value}, "--block");
  }
  expect_refused({"--disparities", "257"}, "--disparities");
  expect_refused({"--slot", "c"}, "--slot takes a or b");
  expect_refused({"--which-slot", "both"}, "--which-slot takes usual or trial");
  expect_refused({"--slots", "/nowhere/card", "--which-slot", "usual"}, "/nowhere/card1 to 3");
  expect_refused({"--records", "/dev/null"}, "--records takes a partition of 12 MiB");
  expect_refused({"--records", "/nowhere", "--keys", "/nowhere/keys"}, "leave them out");
  expect_refused({"--update-keys", "/dev/null"}, "64 hexadecimal digits");
  expect_refused({"--preset", "best"}, "fast or quality, or chapter");
  expect_refused({"--method", "sa"}, "--method");
  expect_refused({"--lr=-1"}, "--lr");
  expect_refused({"--no-block"}, "--no-block");
  expect_refused({"--fill"}, "--fill");
  expect_refused({"--shape", "region"}, "--shape");  // of stof evaluate alone
  expect_refused({"--period-ms", "-1"}, "--period-ms");
  expect_refused({"--set", "streams.depth"}, "PATH=VALUE");
  expect_refused({"--set", "streams.depth=zip"}, "off, raw, rvl or fit");
  expect_refused({"--set", "moon=1"}, "moon");
  expect_refused({"--port", "65536"}, "--port");
  expect_refused({"--to", "nowhere"}, "nowhere");
  expect_refused({"--to", "127.0.0.1:99999"}, "99999");
  expect_refused({"--to"}, "--to");
  expect_refused({"--scene", "moon"}, "moon");
  expect_refused({"--tof", "x"}, "--tof");
  for (const char* const value : {"stereo", "stereo:drop", "moon:drop:1", "stereo:moon:1",
                                  "stereo:drop:x", "stereo:drop:1:2:3", "stereo:drop:1+",
                                  "stereo:drop:1+0", "stereo:drop:+3", "stereo:drop:1+2+3"}) {
    expect_refused({"--fault", value}, "--fault");
  }
  expect_refused({"--scene", "corridor", "--dataset", "x"}, "exclude");
}

TEST_F(StofdTest, BadDatasetsEndInOneLineAndCodeTwo) {
  expect_refused({"--dataset", path("none")}, path("none"));
  fs::create_directory(dir_ / "empty");
  expect_refused({"--dataset", path("empty")}, "left.pgm");
  const std::string cut = dataset("cut");
  write("cut/left.pgm", pgm(48, 32).substr(0, 700));
  expect_refused({"--dataset", cut}, "left.pgm");
  const std::string uneven = dataset("uneven");
  write("uneven/right.pgm", pgm(47, 32));
  expect_refused({"--dataset", uneven}, "right.pgm");
  const std::string good = dataset("good");
  expect_refused({"--dataset", good, "--tof", path("tof")}, path("tof"));
  expect_refused({"--dataset", good, "--truth", path("truth.pfm")}, "gt_left.pgm");
  expect_refused({"--dataset", good, "--period-ms", "10"}, "period");
  expect_refused({"--dataset", good, "--disparities", "200"}, "--disparities");
  expect_refused({"--dataset", dataset("wide", 1281, 8)}, "1281x8");
  expect_refused({"--dataset", dataset("high", 8, 721)}, "8x721");
}

TEST_F(StofdTest, BadCalibrationFilesEndInOneLineAndCodeTwo) {
  const std::string good = dataset("good");
  const auto with = [&](const std::string& file) {
    return std::vector<std::string>{"--dataset", good, "--calibration", file};
  };
  expect_refused(with(path("none")), "none");
  expect_refused(with(dir_.string()), dir_.string());
  write("text", "not a calibration");
  expect_refused(with(path("text")), "text");

  dsp::Calibration calibration;
  calibration.stereo = {.left = {.width = 48, .height = 32, .fx = 50, .fy = 50, .cx = 24, .cy = 16},
                        .baseline_m = 0.1};
  const auto encode = [](const dsp::Calibration& of) {
    std::string bytes(wire::calibration_file_bytes(of), '\0');
    EXPECT_TRUE(wire::encode_calibration_file(of, std::as_writable_bytes(std::span(bytes))));
    return bytes;
  };
  const std::string bytes = encode(calibration);
  write("good.cal", bytes);
  EXPECT_EQ(run_stofd({"--dataset", good, "--calibration", path("good.cal"), "--frames", "1",
                       "--free-run"})
                .code,
            0);
  for (const std::size_t at : {std::size_t{0}, bytes.size() / 2, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write("damaged.cal", damaged);
    expect_refused(with(path("damaged.cal")), "damaged.cal");
    write("short.cal", bytes.substr(0, at));
    expect_refused(with(path("short.cal")), "short.cal");
  }
  calibration.stereo.left.width = 64;
  write("other.cal", encode(calibration));
  expect_refused(with(path("other.cal")), "64x32");
  calibration.stereo.left.width = 48;
  calibration.stereo.baseline_m = 0;
  write("flat.cal", encode(calibration));
  expect_refused(with(path("flat.cal")), "flat.cal");
}

// Two cameras that are turned by a tenth of a radian against each other, as large as the dataset.
dsp::Calibration raw_calibration() {
  dsp::Calibration calibration;
  dsp::RawPair& pair = calibration.stereo.raw.emplace();
  pair.left = {.width = 48, .height = 32, .fx = 50, .fy = 50, .cx = 23.5, .cy = 15.5, .k1 = -0.1};
  pair.right = pair.left;
  pair.right.fx = pair.right.fy = 52;
  pair.left_to_right = {
      {0.995004165278, 0, 0.0998334166468, 0, 1, 0, -0.0998334166468, 0, 0.995004165278},
      {-0.1, 0, 0}};
  return calibration;
}

TEST_F(StofdTest, SendsTheRectifiedCameraOfARawPair) {
  const dsp::Calibration calibration = raw_calibration();
  std::string bytes(wire::calibration_file_bytes(calibration), '\0');
  ASSERT_TRUE(wire::encode_calibration_file(calibration, std::as_writable_bytes(std::span(bytes))));
  write("raw.cal", bytes);
  const Socket socket;
  const Stofd stofd(
      {"--dataset", dataset("good"), "--to", socket.destination, "--calibration", path("raw.cal")});
  while (true) {
    const std::vector<std::byte> datagram = socket.receive();
    ASSERT_FALSE(datagram.empty());
    const auto packet = wire::parse_packet(datagram);
    ASSERT_TRUE(packet);
    if (packet->header.type == wire::PacketType::kCalibration) {
      const auto received = wire::read_calibration_packet(packet->payload);
      ASSERT_TRUE(received);
      EXPECT_EQ(received->fx, 51 * 65536);
      EXPECT_EQ(received->image_width, 48);
      EXPECT_EQ(received->baseline_nm, 100'000'000);
      break;
    }
  }
  stofd.signal(SIGTERM);
  EXPECT_EQ(stofd.end().code, 0);
}

TEST_F(StofdTest, PairsThatCannotBeRectifiedEndInOneLineAndCodeTwo) {
  const std::string good = dataset("good");
  const auto refused = [&](const dsp::Calibration& calibration, const std::string& about) {
    std::string bytes(wire::calibration_file_bytes(calibration), '\0');
    ASSERT_TRUE(
        wire::encode_calibration_file(calibration, std::as_writable_bytes(std::span(bytes))));
    write("raw.cal", bytes);
    expect_refused({"--dataset", good, "--calibration", path("raw.cal")}, about);
  };
  dsp::Calibration calibration = raw_calibration();
  calibration.stereo.raw->left_to_right.translation_m = {0.1, 0, 0};
  refused(calibration, "right");
  calibration = raw_calibration();
  calibration.stereo.raw->right.width = 47;
  refused(calibration, "size");
  calibration = raw_calibration();
  calibration.stereo.raw->left.width = calibration.stereo.raw->right.width = 64;
  refused(calibration, "64x32");
  calibration = raw_calibration();
  calibration.stereo.converging.emplace();
  refused(calibration, "leave one");
}

TEST_F(StofdTest, TinyAndFlatPicturesRunThrough) {
  const std::string tiny = dataset("tiny", 1, 1);
  const Ended ended = run_stofd({"--dataset", tiny, "--frames", "3", "--free-run"});
  EXPECT_EQ(ended.code, 0) << ended.error;
  EXPECT_NE(ended.out.find("3 frames published"), std::string::npos) << ended.out;
  const std::string narrow = dataset("narrow", 5, 40, 64);  // fewer columns than disparities
  EXPECT_EQ(run_stofd({"--dataset", narrow, "--frames", "3", "--free-run"}).code, 0);
  const std::string flat = dataset("flat");
  for (const int grey : {0, 255}) {
    const std::string picture = "P5\n48 32\n255\n" + std::string(48 * 32, static_cast<char>(grey));
    write("flat/left.pgm", picture);
    write("flat/right.pgm", picture);
    EXPECT_EQ(run_stofd({"--dataset", flat, "--frames", "3", "--free-run"}).code, 0);
  }
}

TEST_F(StofdTest, SaysWhatIsMissing) {
  const Ended ended = run_stofd({"--dataset", dataset("good"), "--frames", "2", "--free-run"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_NE(ended.out.find("depth from stereo alone"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("are assumed"), std::string::npos) << ended.out;
}

TEST_F(StofdTest, WritesTheTruthOfADatasetInMetres) {
  const std::string folder = dataset("good");
  write("good/meta.txt", "ndisp 8\ngt_scale 4\n");
  write("good/gt_left.pgm", pgm(48, 32));
  ASSERT_EQ(
      run_stofd({"--dataset", folder, "--frames", "1", "--free-run", "--truth", path("truth.pfm")})
          .code,
      0);
  std::ifstream file(path("truth.pfm"), std::ios::binary);
  std::string header;
  std::getline(file, header);
  EXPECT_EQ(header, "Pf");
  expect_refused({"--dataset", folder, "--truth", path("no/truth.pfm")}, "truth.pfm");
}

TEST_F(StofdTest, SendsValidPacketsAndStopsCleanlyOnASignal) {
  for (const int number : {SIGTERM, SIGINT}) {
    const Socket socket;
    const Stofd stofd({"--dataset", dataset("good"), "--to", socket.destination, "--device", "77",
                       "--session", "88"});
    bool calibrated = false;
    bool informed = false;
    while (!calibrated || !informed) {
      const std::vector<std::byte> bytes = socket.receive();
      ASSERT_FALSE(bytes.empty());
      const auto packet = wire::parse_packet(bytes);
      ASSERT_TRUE(packet);
      EXPECT_EQ(packet->header.origin.device_id, 77U);
      EXPECT_EQ(packet->header.origin.session_id, 88U);
      calibrated = calibrated || packet->header.type == wire::PacketType::kCalibration;
      informed = informed || packet->header.type == wire::PacketType::kFrameInfo;
    }
    stofd.signal(number);
    const Ended ended = stofd.end();
    EXPECT_EQ(ended.code, 0);
    EXPECT_EQ(ended.error, "");
    EXPECT_NE(ended.out.find("frames published of"), std::string::npos) << ended.out;
  }
}

}  // namespace
}  // namespace stof::firmware::test

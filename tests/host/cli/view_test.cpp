#include "host/cli/view/view.h"

#include <array>
#include <csignal>
#include <cstring>
#include <optional>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "dataset/dataset.h"
#include "dataset/files/file.h"
#include "firmware/wire/calibration/calibration_packet.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/cli/failure.h"
#include "tests/dataset/scratch.h"
#include "tests/host/client/loopback_sender.h"
#include "tests/host/client/sent_frame.h"

// view() against a sender on loopback that speaks through the appliance's own coder.
namespace stof::host {
namespace {

using namespace std::chrono_literals;

constexpr int kWidth = 8;
constexpr int kHeight = 6;

class LoopbackSink {
 public:
  explicit LoopbackSink(std::uint16_t port) : sender_(port) { EXPECT_TRUE(sender_.connected()); }
  void send(std::span<const std::byte> datagram) {
    ++sent;
    if (sent != drop) {
      EXPECT_EQ(sender_.send(datagram), Status::kOk);
    }
  }

  int sent = 0;
  int drop = 0;  // the datagram of this number, from 1, is lost on the way

 private:
  test::LoopbackSender sender_;
};

// Frame n: every pixel n metres away, the first pixel without depth.
struct SentFrame {
  dataset::Image<dsp::QuarterMm> depth;
  dataset::Image<dsp::QuarterMm> width;
  dataset::Image<dsp::Source> source;
  dataset::Image<dsp::Disparity> disparity{kWidth, kHeight, dsp::Disparity::from_pixels(20)};
  dataset::Image<std::uint8_t> grey{kWidth, kHeight, 200};

  explicit SentFrame(std::uint32_t n)
      : depth(kWidth, kHeight, static_cast<dsp::QuarterMm>(n * 4000)),
        width(kWidth, kHeight, 80),
        source(kWidth, kHeight, dsp::Source::kBoth) {
    depth.pixels[0] = width.pixels[0] = 0;
    source.pixels[0] = dsp::Source::kNone;
  }
  wire::FrameImages images() {
    return {.map = {depth.view(), width.view(), source.view()},
            .disparity = disparity.view(),
            .pmd = {},
            .left = grey.view(),
            .right = grey.view()};
  }
};

class View : public test::Scratch {
 protected:
  View() {
    options_.port = 0;
    options_.bind = "127.0.0.1";
    options_.port_file = folder() / "port";
    options_.timeout_s = 60;
    // What this computer does meanwhile makes nothing old, nor a frame late.
    options_.reassembler.max_age = 600s;
    options_.reassembler.frame_timeout = 600s;
  }

  // The port, when view() has opened it.
  std::uint16_t wait_for_port() const {
    for (int i = 0; i < 12'000; ++i) {
      int port = 0;
      if (std::ifstream(options_.port_file) >> port && port != 0) {
        return static_cast<std::uint16_t>(port);
      }
      std::this_thread::sleep_for(5ms);
    }
    ADD_FAILURE() << "view() opened no port";
    return 1;
  }

  void send_frames(std::uint32_t count, bool with_calibration, int drop) const {
    LoopbackSink sink(wait_for_port());
    sink.drop = drop;
    const wire::Origin origin{.device_id = 1, .session_id = 2};
    test::Coder coder(origin, {.width = kWidth, .height = kHeight});
    for (std::uint32_t n = 1; n <= count; ++n) {
      SentFrame frame(n);
      const wire::FrameStamp stamp{.number = n, .freshness = n};
      if (with_calibration) {
        sink.send(calibration(origin));
      }
      for (const test::Datagram& packet : coder.code(stamp, frame.images(), choice_)) {
        sink.send(packet);
      }
    }
    for (const test::Datagram& packet : reports_) {
      sink.send(packet);
    }
  }

  static test::Datagram calibration(const wire::Origin& origin) {
    const dsp::Calibration rig{
        .stereo =
            {.left = {.width = kWidth, .height = kHeight, .fx = 10, .fy = 10, .cx = 3, .cy = 2},
             .baseline_m = 0.1,
             .doff_px = 0},
        .pmd = {},
        .pmd_to_stereo = {}};
    std::array<std::byte, wire::kCalibrationPacketBytes> payload{};
    wire::encode_calibration_packet(wire::make_calibration_packet(rig, 40000, 33'000'000).value(),
                                    payload);
    return test::report_datagram({.origin = origin}, wire::PacketType::kCalibration, payload);
  }

  // Runs view() with a sender; what it printed and how it ended.
  void run(std::uint32_t count, bool with_calibration = true, int drop = 0) {
    std::thread sender(
        [this, count, with_calibration, drop] { send_frames(count, with_calibration, drop); });
    testing::internal::CaptureStdout();
    try {
      view(options_);
    } catch (const Failure& failure) {
      failure_ = failure;
    }
    printed_ = testing::internal::GetCapturedStdout();
    sender.join();
  }
  bool said(std::string_view text) const { return printed_.find(text) != std::string::npos; }
  std::filesystem::path out() const { return folder() / "out"; }

  ViewOptions options_;
  wire::StreamChoice choice_ = test::raw_map();
  std::vector<test::Datagram> reports_;  // after the frames
  std::string printed_;
  std::optional<Failure> failure_;
};

TEST_F(View, LeavesPicturesOfWhatItReceived) {
  options_.frames = 3;
  options_.out = out();
  run(3);
  EXPECT_FALSE(failure_.has_value()) << failure_->what();
  EXPECT_TRUE(said("3 frames received, 3 verified whole")) << printed_;
  EXPECT_TRUE(said("nothing lost")) << printed_;
  EXPECT_TRUE(said("made from received packets only")) << printed_;
  EXPECT_TRUE(said("coverage 97.9 %")) << printed_;  // 47 of 48
  EXPECT_GT(std::filesystem::file_size(out() / "depth.png"), 0U);
  EXPECT_GT(std::filesystem::file_size(out() / "depth_color.png"), 0U);
  std::ifstream stream(out() / "cloud.ply", std::ios::binary);
  const std::string ply(std::istreambuf_iterator<char>(stream), {});
  EXPECT_NE(ply.find("element vertex 47\n"), std::string::npos);
  // The last point is the last pixel of the last frame: 3 m away, 4 columns right, 3 rows down.
  float point[4];
  ASSERT_GT(ply.size(), 17U);
  std::memcpy(point, ply.data() + ply.size() - 17, sizeof point);
  EXPECT_NEAR(point[0], 1.2F, 1e-4F);  // lens and points are rounded on their way
  EXPECT_NEAR(point[1], 0.9F, 1e-4F);
  EXPECT_EQ(point[2], 3.0F);
  EXPECT_EQ(point[3], 0.005F);
}

TEST_F(View, ShowsTheStreamsThatCome) {
  options_.frames = 2;
  options_.out = out();
  for (const wire::Stream stream :
       {wire::Stream::kDisparity, wire::Stream::kGreyLeft, wire::Stream::kGreyRight}) {
    choice_.of(stream) = wire::Coding::kRvl;
  }
  choice_.parity = true;
  run(2, true, 13);  // without the width of frame 2, which parity makes good
  EXPECT_FALSE(failure_.has_value()) << failure_->what();
  EXPECT_TRUE(said("streams: depth 8x6, width 8x6, source 8x6, disparity 8x6, left 8x6, right 8x6"))
      << printed_;
  EXPECT_TRUE(said("2 frames received, 2 verified whole")) << printed_;
  for (const char* name : {"depth.png", "source.png", "disparity.png", "left.png", "right.png"}) {
    EXPECT_TRUE(std::filesystem::exists(out() / name)) << name;
    EXPECT_TRUE(said(name)) << printed_;
  }
  EXPECT_NE(
      dataset::read_whole(out() / "source.png", 100'000).value_or("").find("violet: resolved"),
      std::string::npos);
}

TEST_F(View, SaysWhatParityMadeGood) {
  options_.frames = 1;
  choice_.parity = true;
  run(1, true, 3);
  EXPECT_FALSE(failure_.has_value()) << failure_->what();
  EXPECT_TRUE(said("1 frames received, 1 verified whole")) << printed_;
  EXPECT_TRUE(said("1 packets made of parity, nothing lost")) << printed_;
}

TEST_F(View, DoesWithoutDepth) {
  options_.frames = 2;
  options_.out = out();
  choice_ = {};
  choice_.of(wire::Stream::kGreyLeft) = wire::Coding::kRaw;
  run(2);
  EXPECT_FALSE(failure_.has_value()) << failure_->what();
  EXPECT_TRUE(said("streams: left 8x6\n")) << printed_;
  EXPECT_TRUE(said("no depth arrived")) << printed_;
  EXPECT_TRUE(std::filesystem::exists(out() / "left.png"));
  EXPECT_FALSE(std::filesystem::exists(out() / "depth.png"));
}

TEST_F(View, SaysWhatTheSensorSaysOfItself) {
  const wire::Origin origin{.device_id = 1, .session_id = 2};
  std::array<std::byte, wire::kHealthReportBytes> health{};
  wire::encode_health_report({.uptime_ms = 5000,
                              .active = 1U << 2,
                              .severity = wire::Severity::kCritical,
                              .reaction = wire::Reaction::kStop,
                              .subscribers = 1},
                             health);
  std::array<std::byte, wire::kEventReportBytes> event{};
  wire::encode_event_report(
      {.sequence = 1, .condition = 2, .reaction = wire::Reaction::kStop, .active = 1}, event);
  reports_ = {test::report_datagram({.origin = origin}, wire::PacketType::kEvent, event),
              test::report_datagram({.origin = origin}, wire::PacketType::kEvent, event),
              test::report_datagram({.origin = origin}, wire::PacketType::kHealth, health)};
  options_.timeout_s = 3;
  run(1);  // goes on until the timeout
  EXPECT_TRUE(
      said("event: stereo_lost began: a stereo camera is gone; bring the robot to a safe "
           "stop\n"))
      << printed_;
  EXPECT_EQ(printed_.find("event:"), printed_.rfind("event:"));
  EXPECT_TRUE(said("health: no data, up 5 s")) << printed_;
  EXPECT_TRUE(said("active: stereo_lost; bring the robot to a safe stop")) << printed_;
}

TEST_F(View, ScoresAgainstTheTruth) {
  dataset::Image<float> truth(kWidth, kHeight, 2.0F);
  truth.pixels[1] = 4;  // one pixel is wrong, one is missing
  options_.truth = folder() / "truth.pfm";
  ASSERT_TRUE(dataset::write_pfm(options_.truth, truth));
  options_.frames = 2;
  run(2);
  EXPECT_FALSE(failure_.has_value()) << failure_->what();
  EXPECT_TRUE(said("error 0.0 mm median, E5 0.042")) << printed_;  // 2 of 48
}

TEST_F(View, RefusesTruthOfAnotherSize) {
  options_.truth = folder() / "truth.pfm";
  ASSERT_TRUE(dataset::write_pfm(options_.truth, dataset::Image<float>(2, 2, 2.0F)));
  options_.frames = 1;
  run(1);
  ASSERT_TRUE(failure_.has_value());
  EXPECT_EQ(failure_->code(), Exit::kBadInput);
  test::expect_one_line_about(failure_->what(), options_.truth, "not of the received frames' size");
}

TEST_F(View, CountsWhatIsMissingAndDrawsNothingInItsPlace) {
  options_.frames = 1;
  options_.out = out();
  options_.reassembler.frame_timeout = 1s;  // the stream has stopped
  run(1, true, 3);                          // calibration, frame info, then the depth's only tile
  EXPECT_FALSE(failure_.has_value()) << failure_->what();
  EXPECT_TRUE(said("1 frames received, 0 verified whole")) << printed_;
  EXPECT_TRUE(said("1 packets missing")) << printed_;
  EXPECT_TRUE(said("coverage 0.0 %")) << printed_;
  std::ifstream stream(out() / "cloud.ply", std::ios::binary);
  const std::string ply(std::istreambuf_iterator<char>(stream), {});
  EXPECT_NE(ply.find("element vertex 0\n"), std::string::npos);
}

TEST_F(View, SaysWhenNoCalibrationCameForACloud) {
  options_.frames = 1;
  options_.out = out();
  run(1, false);
  EXPECT_FALSE(failure_.has_value()) << failure_->what();
  EXPECT_TRUE(said("no cloud: no calibration packet")) << printed_;
  EXPECT_TRUE(std::filesystem::exists(out() / "depth.png"));
  EXPECT_FALSE(std::filesystem::exists(out() / "cloud.ply"));
}

TEST_F(View, FailsInOneLineWhenTheStreamEndsEarly) {
  options_.frames = 5;
  options_.timeout_s = 3;
  run(2);
  ASSERT_TRUE(failure_.has_value());
  EXPECT_EQ(failure_->code(), Exit::kFailure);
  EXPECT_NE(std::string(failure_->what()).find("ended after 2 frames"), std::string::npos);
  EXPECT_TRUE(said("2 frames received")) << printed_;
}

TEST_F(View, FailsInOneLineWhenNothingComes) {
  options_.timeout_s = 0.2;
  run(0);
  ASSERT_TRUE(failure_.has_value());
  EXPECT_EQ(failure_->code(), Exit::kFailure);
  EXPECT_NE(std::string(failure_->what()).find("no packet came"), std::string::npos);
  EXPECT_EQ(std::string(failure_->what()).find('\n'), std::string::npos);
}

TEST_F(View, EndsWithItsPicturesWhenInterrupted) {
  options_.out = out();
  std::thread interrupter([this] {
    for (int i = 0; i < 12'000 && !std::filesystem::exists(folder() / "sent"); ++i) {
      std::this_thread::sleep_for(5ms);
    }
    std::this_thread::sleep_for(2s);  // what was sent has long arrived
    kill(getpid(), SIGTERM);
  });
  std::thread sender([this] {
    send_frames(2, true, 0);
    put("sent", "");
  });
  testing::internal::CaptureStdout();
  EXPECT_NO_THROW(view(options_));
  printed_ = testing::internal::GetCapturedStdout();
  sender.join();
  interrupter.join();
  EXPECT_TRUE(said("2 frames received")) << printed_;
  EXPECT_TRUE(std::filesystem::exists(out() / "cloud.ply"));
}

}  // namespace
}  // namespace stof::host

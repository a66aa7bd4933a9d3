#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "host/recording/recorder.h"
#include "host/recording/recording.h"
#include "host/recording/session_recording.h"
#include "tests/dataset/scratch.h"

namespace stof {
namespace {

using namespace std::chrono_literals;

// The time of a report by the log, from the first frame on, and the report's uptime.
using Recorded = std::vector<std::pair<std::chrono::milliseconds, std::uint64_t>>;

class RecordedHealth : public test::Scratch {
 protected:
  RecordedHealth()
      : sink_(*mcap::FileSink::open(file_, mcap::FileSink::Existing::kReplace)),
        recorder_(*recording::Recorder::start(sink_, {.library = "test"})),
        session_(*recorder_, {}, {}) {}

  void frame(std::chrono::milliseconds at, std::uint32_t session = 1) {
    client::Frame frame{.origin = {.device_id = 3, .session_id = session},
                        .stamp = {.number = ++number_}};
    frame.last_packet = client::Time(kBegin + at);
    session_.take(frame, "here");
  }
  void health(std::chrono::milliseconds at, std::uint64_t uptime_ms, std::uint32_t session = 1) {
    session_.take(client::ToldHealth{.report = {.uptime_ms = uptime_ms},
                                     .from = {.device_id = 3, .session_id = session},
                                     .arrived = client::Time(kBegin + at)});
  }

  Recorded read_again() {
    EXPECT_FALSE(recorder_->finish().problem);
    auto reader = recording::FrameReader::open(file_);
    std::uint64_t first = 0;
    while (const auto frame = reader->next()) {
      first = first == 0 ? frame->log_time : first;
    }
    Recorded recorded;
    for (const auto& [time, report] : reader->sights().health) {
      recorded.emplace_back(std::chrono::duration_cast<std::chrono::milliseconds>(
                                std::chrono::nanoseconds(time - first)),
                            report.uptime_ms);
    }
    return recorded;
  }

 private:
  static constexpr std::chrono::seconds kBegin{1000};
  std::filesystem::path file_ = folder() / "health.mcap";
  mcap::FileSink sink_;
  std::unique_ptr<recording::Recorder> recorder_;
  recording::SessionRecording session_;
  std::uint32_t number_ = 0;
};

TEST_F(RecordedHealth, EachHasTheTimeOfItsArrival) {
  frame(0ms);
  health(300ms, 1000);
  health(950ms, 1650);  // two between two frames
  frame(1000ms);
  health(1300ms, 10, 2);  // after a start, before a frame
  frame(2000ms, 2);
  EXPECT_EQ(read_again(), (Recorded{{300ms, 1000}, {950ms, 1650}, {1300ms, 10}}));
}

TEST_F(RecordedHealth, OfWhatCameBeforeTheFirstFrameTheNewestIsOfItsTime) {
  health(-2000ms, 1000);
  health(-1000ms, 2000);
  frame(0ms);
  health(-500ms, 2500);  // the receiver was asked after it
  health(500ms, 3500);
  frame(1000ms);
  EXPECT_EQ(read_again(), (Recorded{{0ms, 2000}, {0ms, 2500}, {500ms, 3500}}));
}

}  // namespace
}  // namespace stof

#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/recording/recorder.h"
#include "host/recording/recording.h"
#include "host/recording/ros_messages.h"
#include "host/recording/session_recording.h"
#include "tests/dataset/scratch.h"

namespace stof {
namespace {

using recording::SensorDocuments;
using recording::Topic;

const std::string kFar = R"({"far": true})";
const std::string kNear = R"({"far": false})";

class RecordedSettings : public test::Scratch {
 protected:
  // A sensor that can be asked, where `asks`.
  void begin(bool asks = true) {
    auto sink = mcap::FileSink::open(file_, mcap::FileSink::Existing::kReplace);
    ASSERT_TRUE(sink);
    sink_.emplace(std::move(*sink));
    recorder_ = *recording::Recorder::start(*sink_, {.library = "test"});
    recording::SessionRecording::Options options;
    if (asks) {
      options.read = [this](bool) { return sensor_; };
    }
    session_.emplace(*recorder_, std::move(options), sensor_);
  }

  // A frame of a sensor that runs with this document and answers with it, unless it is silent; what
  // is asked for is waited for.
  void frame(std::uint32_t session, const std::string& document) {
    if (sensor_.no_settings.empty()) {
      sensor_.settings = document;
    }
    client::Frame frame{.origin = {.device_id = 3, .session_id = session},
                        .stamp = {.number = ++number_}};
    frame.last_packet = client::Time(std::chrono::seconds(number_));
    frame.info.emplace().settings_fingerprint = recording::fingerprint_of(document);
    session_->take(frame, "here");
    session_->finish();
  }
  void falls_silent(const char* reason) { sensor_ = {.no_settings = reason}; }
  void answers_again() { sensor_ = {}; }

  // Ends the file and reads it: the documents, and the newest one at each frame.
  void end() {
    EXPECT_FALSE(recorder_->finish().problem);
    const auto source = mcap::FileSource::open(file_);
    auto reader = mcap::StreamReader::open(*source);
    ASSERT_TRUE(reader);
    for (auto item = reader->next(); item && *item; item = reader->next()) {
      if (const auto* const message = std::get_if<mcap::Message>(&**item)) {
        const auto topic = recording::topic_of(reader->index(), message->channel_id);
        if (topic == Topic::kSettings) {
          documents_.push_back(recording::decode_string(message->data).value_or("damaged"));
        } else if (topic == Topic::kFrameInfo) {
          in_force_.push_back(documents_.empty() ? "" : documents_.back());
        }
      } else if (const auto* const metadata = std::get_if<mcap::Metadata>(&**item)) {
        metadata_.push_back(metadata->entries);
      }
    }
  }

  std::vector<std::string> documents_;
  std::vector<std::string> in_force_;
  std::vector<mcap::TextMap> metadata_;

 private:
  std::filesystem::path file_ = folder() / "r.mcap";
  SensorDocuments sensor_{.settings = kFar};
  std::optional<mcap::FileSink> sink_;
  std::unique_ptr<recording::Recorder> recorder_;
  std::optional<recording::SessionRecording> session_;
  std::uint32_t number_ = 0;
};

// The sensor was restarted, and had not saved what was changed.
TEST_F(RecordedSettings, OfANewSessionAreThereAgain) {
  begin();
  frame(5, kFar);
  frame(5, kNear);
  frame(5, kNear);
  frame(6, kFar);
  frame(6, kFar);
  end();
  EXPECT_EQ(documents_, (std::vector<std::string>{kFar, kNear, kFar}));
  EXPECT_EQ(in_force_, (std::vector<std::string>{kFar, kFar, kNear, kFar, kFar}));
  ASSERT_EQ(metadata_.size(), 2U);
  EXPECT_EQ(metadata_[0].at("settings"), "attachment settings.json");
  EXPECT_NE(metadata_[1].at("settings").find("on its topic"), std::string::npos)
      << metadata_[1].at("settings");
}

TEST_F(RecordedSettings, OfANewSessionAreThereAlsoWhereNothingChanged) {
  begin();
  frame(5, kFar);
  frame(6, kFar);
  end();
  EXPECT_EQ(documents_, (std::vector<std::string>{kFar, kFar}));
}

TEST_F(RecordedSettings, ThatAreWhatTheyWereAreThereAgain) {
  begin();
  frame(5, kFar);
  frame(5, kNear);
  frame(5, kFar);
  end();
  EXPECT_EQ(documents_, (std::vector<std::string>{kFar, kNear, kFar}));
  EXPECT_EQ(in_force_.back(), kFar);
}

TEST_F(RecordedSettings, ThatNobodyTellsAreSaidToBeMissing) {
  begin();
  frame(5, kFar);
  falls_silent("it does not answer");
  frame(6, kNear);
  end();
  EXPECT_EQ(documents_, (std::vector<std::string>{kFar}));
  ASSERT_EQ(metadata_.size(), 3U);
  EXPECT_EQ(metadata_.back().at("session_id"), "6");
  EXPECT_EQ(metadata_.back().at("settings"), "it does not answer");
  EXPECT_NE(metadata_.back().at("settings_not_read").find("it does not answer"), std::string::npos);
}

TEST_F(RecordedSettings, ThatNobodyToldAreAskedForAgainInANewSession) {
  falls_silent("it does not answer");
  begin();
  frame(5, kFar);
  answers_again();
  frame(5, kFar);
  frame(6, kFar);
  end();
  EXPECT_EQ(documents_, (std::vector<std::string>{kFar}));
  EXPECT_EQ(metadata_.back().at("session_id"), "6");
  EXPECT_FALSE(metadata_.back().contains("settings_not_read"));
}

TEST_F(RecordedSettings, OfASensorThatIsNotAskedAreNotSaidToBeThere) {
  falls_silent("it was not asked");
  begin(false);
  frame(5, kFar);
  frame(6, kFar);
  end();
  ASSERT_EQ(metadata_.size(), 2U);
  EXPECT_EQ(metadata_[1].at("settings"), "it was not asked");
}

}  // namespace
}  // namespace stof

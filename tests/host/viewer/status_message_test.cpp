#include "host/viewer/status_message.h"

#include <array>
#include <cstddef>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/picture/source_colours.h"

namespace stof::viewer {
namespace {

TEST(StatusMessage, SourcesHaveTheColoursOfThePictures) {
  const auto hello = nlohmann::json::parse(hello_message("here", {}, false));
  const nlohmann::json& sources = hello.at("sources");
  ASSERT_EQ(sources.size(), host::kSourceColours.size());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const host::Rgb colour = host::kSourceColours[i];
    std::array<char, 8> text{};
    std::snprintf(text.data(), text.size(), "#%02x%02x%02x", unsigned{colour.red},
                  unsigned{colour.green}, unsigned{colour.blue});
    EXPECT_EQ(sources[i].at("colour"), text.data()) << sources[i].at("name");
  }
}

TEST(StatusMessage, AnEventOfARecordingHasTheTimeOfItsRecording) {
  constexpr std::uint64_t kThen = 1'700'000'000'123;
  const auto event =
      nlohmann::json::parse(event_message({.condition = 3, .active = 1}, "pmd_lost", kThen));
  EXPECT_EQ(event.at("time_ms"), kThen);
  EXPECT_EQ(event.at("active"), true);
}

TEST(StatusMessage, FramesThatCameTooLateAreLostAndToldApart) {
  const client::Statistics counts{.frames_stale = 1, .frames_old = 4, .frames_lost = 2};
  const auto status = nlohmann::json::parse(
      status_message({.statistics = counts, .link = {}, .health = std::nullopt}));
  EXPECT_EQ(status.at("lost"), 7);
  EXPECT_EQ(status.at("late"), 5);
}

TEST(StatusMessage, AnEventOfTheLinkIsOfNoCondition) {
  const auto event = nlohmann::json::parse(event_message(
      LinkEvent{.text = "link: silent", .severity = wire::Severity::kMajor, .active = true}, 5));
  EXPECT_EQ(event.at("type"), "event");
  EXPECT_EQ(event.at("text"), "link: silent");
  EXPECT_TRUE(event.at("condition").is_null());
  EXPECT_EQ(event.at("severity"), static_cast<int>(wire::Severity::kMajor));
  EXPECT_EQ(event.at("active"), true);
  EXPECT_EQ(event.at("time_ms"), 5);
}

}  // namespace
}  // namespace stof::viewer

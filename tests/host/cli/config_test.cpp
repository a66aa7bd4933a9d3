#include "host/cli/config/config.h"

#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "host/cli/config/settings_text.h"
#include "host/cli/failure.h"
#include "tests/host/cli/sensor_stub.h"

namespace stof::host {
namespace {

class StubTransport final : public client::ControlTransport {
 public:
  explicit StubTransport(SensorStub* sensor) : sensor_(sensor) {}

  Status send(std::span<const std::byte> packet) override {
    if (sensor_ != nullptr) {
      if (auto answer = sensor_->answer(packet)) {
        answers_.push_back(std::move(*answer));
      }
    }
    return Status::kOk;
  }
  Result<std::vector<std::byte>> receive(client::Duration /*timeout*/) override {
    if (answers_.empty()) {
      return fail(Status::kTimeout);
    }
    std::vector<std::byte> answer = std::move(answers_.front());
    answers_.pop_front();
    return answer;
  }
  std::string place() const override { return "stub"; }

 private:
  SensorStub* sensor_;
  std::deque<std::vector<std::byte>> answers_;
};

class ConfigTest : public testing::Test {
 protected:
  std::string run(const std::vector<std::string>& words, const ConfigOptions& options = {}) {
    return config_over(std::make_unique<StubTransport>(&sensor_), words, options);
  }

  // The line it ends with, and its code.
  std::pair<std::string, Exit> refusal(const std::vector<std::string>& words) {
    try {
      return {"printed " + run(words), Exit::kOk};
    } catch (const Failure& failure) {
      return {failure.what(), failure.code()};
    }
  }

  SensorStub sensor_;
};

TEST_F(ConfigTest, GetsAllAPartAndAValue) {
  const Json all = Json::parse(run({"get"}));
  EXPECT_EQ(all["name"], "stof");
  EXPECT_EQ(all["depth"]["match"]["lr"], "preset");
  EXPECT_EQ(Json::parse(run({"get", "depth.match"})), all["depth"]["match"]);
  EXPECT_EQ(run({"get", "name"}), "stof\n");
  EXPECT_EQ(run({"get", "udp.port"}), "7560\n");
  EXPECT_EQ(run({"get", "name"}, {.json = true}), "\"stof\"\n");
  EXPECT_EQ(
      refusal({"get", "depth.colour"}),
      std::pair("depth.colour: this sensor has no such setting: try get alone" + std::string(),
                Exit::kBadInput));
}

TEST_F(ConfigTest, SetsValuesOfEveryType) {
  EXPECT_EQ(run({"set", "name=left arm", "period_ms=50", "depth.guided=true", "streams.depth=raw",
                 "depth.match.lr=2", "depth.match.block=9x9", "depth.match.median=false"}),
            "revision 2, in force, until the next start: save keeps it\n");
  const settings::Settings& active = sensor_.server.active();
  EXPECT_EQ(active.name.view(), "left arm");
  EXPECT_EQ(active.period_ms, 50);
  EXPECT_TRUE(active.depth.guided);
  EXPECT_EQ(active.streams.of(wire::Stream::kDepth), wire::Coding::kRaw);
  EXPECT_EQ(sensor_.store.saves(), 0);
  EXPECT_EQ(run({"get", "name"}, {.document = "saved"}), "stof\n");
  EXPECT_EQ(run({"save"}), "revision 2, saved\n");
  EXPECT_EQ(run({"get", "name"}, {.document = "saved"}), "left arm\n");
  EXPECT_EQ(run({"set", "name=\"12\""}).substr(0, 10), "revision 3");
  EXPECT_EQ(sensor_.server.active().name.view(), "12");
  EXPECT_EQ(run({"set", "udp.port=7000"}, {.json = true}), "{\"revision\":4,\"restart\":true}\n");
  // In force at no time as long as it is not saved, and so it is said.
  EXPECT_EQ(run({"set", "udp.port=7001"}),
            "revision 5, taken; save it: some settings come into force with the next start, and "
            "only if they are saved\n");
  EXPECT_EQ(run({"save"}), "revision 5, saved; some settings wait for the next start\n");
}

TEST_F(ConfigTest, RefusalsOfTheSensorAreTheLine) {
  EXPECT_EQ(refusal({"set", "name=a", "streams.depth=foo"}),
            std::pair(std::string("stub: streams.depth: takes off, raw, rvl or fit, not \"foo\""),
                      Exit::kBadInput));
  EXPECT_EQ(refusal({"set", "depth.disparities=200"}).second, Exit::kBadInput);
  EXPECT_EQ(refusal({"preset", "sea"}).first,
            "stub: preset: takes indoor, outdoor, near, fast or quality");
  EXPECT_EQ(sensor_.server.active(), settings::Settings{});
  sensor_.store.break_down(true);
  EXPECT_EQ(refusal({"stage", "name=a"}).second, Exit::kOk);
  EXPECT_EQ(refusal({"commit"}).second, Exit::kFailure);
}

TEST_F(ConfigTest, StagesCommitsAndReverts) {
  EXPECT_EQ(run({"stage", "name=a"}), "revision 1, staged: commit brings it into force\n");
  EXPECT_EQ(run({"get", "name"}, {.document = "staged"}), "a\n");
  EXPECT_EQ(run({"revert"}), "revision 1, nothing is staged\n");
  EXPECT_EQ(run({"commit"}), "revision 1, in force and saved\n");
  EXPECT_EQ(run({"stage", "name=b"}), "revision 1, staged: commit brings it into force\n");
  EXPECT_EQ(run({"commit"}), "revision 2, in force and saved\n");
  EXPECT_EQ(sensor_.store.saves(), 1);
  EXPECT_EQ(run({"preset", "near"}), "revision 3, in force, until the next start: save keeps it\n");
  EXPECT_EQ(run({"diff"}),
            "name                b  (default stof)\n"
            "depth.max_range_mm  2000  (default 10000)\n"
            "depth.guided        true  (default false)\n"
            "depth.temporal      true  (default false)\n");
  EXPECT_EQ(Json::parse(run({"diff"}, {.json = true}))["depth.guided"]["value"], true);
  EXPECT_TRUE(run({"reset"}).starts_with("revision 4, every setting at its default"));
  static_cast<void>(run({"set", "name=front"}));
  EXPECT_NE(run({"reset"}).find("it was called \"front\" and is called \"stof\" now\n"),
            std::string::npos);
  EXPECT_EQ(run({"reset"}).find("called"), std::string::npos);
  EXPECT_EQ(run({"diff"}), "every setting is at its default\n");
  EXPECT_EQ(Json::parse(run({"schema"}))["type"], "object");
}

// All fields at once are more than one request takes.
TEST_F(ConfigTest, SetsWholeDocumentsAtomically) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("stof_config_" + std::to_string(::getpid()));
  Json document = Json::parse(run({"get"}));
  document["name"] = "whole";
  document["serial"]["device"] = "/dev/" + std::string(58, 'x');
  document["depth"]["match"]["penalties"] = "10,20";
  document["depth"]["match"]["subpixel"] = "equiangular";
  document["discovery"]["beacon"] = false;
  Json older = document;  // of a sensor that knew more searches
  older["depth"]["match"]["method"] = "ordered";
  older["depth"]["match"]["shape"] = "region";
  std::ofstream(file) << older.dump(2);
  EXPECT_EQ(run({"set", file.string()}),
            "revision 2, in force and saved; some settings wait for the next start\n"
            "depth.match.method: not in this version: as the preset has it; "
            "depth.match.shape too\n");
  EXPECT_EQ(Json::parse(run({"get"})), document);
  document = older;

  document["name"] = "refused";
  document["discovery"]["beacon"] = "perhaps";
  std::ofstream(file) << document.dump(2);
  EXPECT_EQ(refusal({"set", file.string()}).first,
            "stub: discovery.beacon: takes true or false, not \"perhaps\"");
  EXPECT_EQ(run({"get", "name"}), "whole\n");
  EXPECT_EQ(run({"get", "name"}, {.document = "staged"}), "whole\n");
  EXPECT_TRUE(run({"set", file.string(), "discovery.beacon=true"}).starts_with("revision 3"));
  std::filesystem::remove(file);
}

TEST_F(ConfigTest, RefusesWhatItCannotSend) {
  EXPECT_EQ(refusal({}).second, Exit::kBadInput);
  EXPECT_EQ(refusal({"erase"}).first,
            "config: \"erase\" is none of get, set, stage, commit, revert, preset, save, reset, "
            "diff or schema");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"set"},
                                             {"stage"},
                                             {"preset"},
                                             {"preset", "a", "b"},
                                             {"get", "a", "b"},
                                             {"save", "now"},
                                             {"set", "nofile.json"},
                                             {"set", "=1"},
                                             {"set", "a..b=1"},
                                             {"set", "depth=1", "depth.max_range_mm=4000"},
                                             {"set", "depth.max_range_mm=4000", "depth=1"},
                                             {"set", "name=" + std::string(2000, 'a')}}) {
    EXPECT_EQ(refusal(words).second, Exit::kBadInput) << words[0];
  }
  EXPECT_EQ(sensor_.requests, 0);
}

TEST(Config, SaysThatNobodyAnswers) {
  try {
    config_over(std::make_unique<StubTransport>(nullptr), {"get"}, {{.timeout_s = 0.01}});
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.code(), Exit::kFailure);
    EXPECT_NE(std::string(failure.what()).find("stub"), std::string::npos);
  }
}

// A sensor that means harm: it answers every request, with as many bytes at a time as it likes,
// after a delay.
class HostileTransport final : public client::ControlTransport {
 public:
  HostileTransport(std::string text, std::size_t bytes, wire::SettingsResult result = {},
                   std::chrono::milliseconds delay = {})
      : text_(std::move(text)), bytes_(bytes), result_(result), delay_(delay) {}

  Status send(std::span<const std::byte> packet) override {
    const auto parsed = wire::parse_packet(packet);
    request_ = *wire::decode_settings_request(parsed->payload);
    return Status::kOk;
  }
  Result<std::vector<std::byte>> receive(client::Duration /*timeout*/) override {
    std::this_thread::sleep_for(delay_);
    wire::DatagramBuffer buffer;
    const auto payload = wire::payload_space(buffer);
    const std::string_view rest =
        std::string_view(text_).substr(std::min<std::size_t>(request_.offset, text_.size()));
    const std::string_view part = rest.substr(0, bytes_);
    wire::encode_settings_answer({.request_id = request_.request_id,
                                  .result = result_,
                                  .total = static_cast<std::uint16_t>(text_.size())},
                                 payload.first<wire::kSettingsAnswerBytes>());
    std::ranges::copy(std::as_bytes(std::span(part)),
                      payload.subspan<wire::kSettingsAnswerBytes>().begin());
    const auto sealed = wire::seal_packet({.type = wire::PacketType::kSettingsAnswer},
                                          wire::kSettingsAnswerBytes + part.size(), buffer);
    return std::vector<std::byte>(sealed.begin(), sealed.end());
  }
  std::string place() const override { return "hostile"; }

 private:
  std::string text_;
  std::size_t bytes_;
  wire::SettingsResult result_;
  std::chrono::milliseconds delay_;
  wire::SettingsRequest request_;
};

// What `stof config` prints or ends with.
std::string told_by(std::unique_ptr<HostileTransport> sensor, const std::string& action) {
  try {
    return config_over(std::move(sensor), {action}, {});
  } catch (const Failure& failure) {
    return failure.what();
  }
}

TEST(HostileSensor, ADeeplyNestedDocumentIsRefused) {
  const std::string nested = "{\"a\":" + std::string(60'000, '[') + "1";
  std::string objects;
  for (int i = 0; i < 9000; ++i) {
    objects += "{\"a\":";
  }
  objects += "1" + std::string(9000, '}');
  for (const std::string& text : {nested, objects}) {
    for (const char* const action : {"get", "diff"}) {
      EXPECT_NE(told_by(std::make_unique<HostileTransport>(text, 1000), action).find("no document"),
                std::string::npos);
    }
  }
}

TEST(HostileSensor, NothingThatControlsATerminalIsPrinted) {
  const std::string escape = "\x1b]0;owned\x07\x7f\xc2\x9b\xff";
  const std::string document = R"({"name":")"
                               "\x7f\xc2\x9b"
                               R"(\u001b[2J"})";
  for (const auto& [text, result] :
       {std::pair(escape, wire::SettingsResult::kInvalid),
        std::pair(escape, wire::SettingsResult{}), std::pair(document, wire::SettingsResult{})}) {
    for (const char* const action : {"get", "schema", "save", "diff"}) {
      const std::string told =
          told_by(std::make_unique<HostileTransport>(text, 1000, result), action);
      EXPECT_EQ(told.find_first_of("\x1b\x07\x7f\x9b\xff"), std::string::npos) << action;
    }
  }
}

TEST(HostileSensor, OneByteAtATimeEndsInTime) {
  using std::chrono::milliseconds;
  client::ControlClient client(
      std::make_unique<HostileTransport>(std::string(65'535, ' '), 1, wire::SettingsResult{},
                                         milliseconds(1)),
      {.overall = milliseconds(20)});
  const auto begin = client::Time::clock::now();
  const auto answer = client.request(wire::SettingsOperation::kGet, {}, {});
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().status, Status::kTimeout);
  EXPECT_LT(client::Time::clock::now() - begin, std::chrono::seconds(2));
}

TEST(SettingsPieces, AreDocumentsThatMakeUpTheWhole) {
  Json document = Json::object();
  for (int k = 0; k < 100; ++k) {
    document["g" + std::to_string(k % 7)]["v" + std::to_string(k)] = k;
  }
  for (const std::size_t most : {25U, 64U, 300U, 100'000U}) {
    Json whole = Json::object();
    const std::vector<std::string> pieces = settings_pieces(document, most);
    for (const std::string& piece : pieces) {
      EXPECT_LE(piece.size(), most);
      whole.merge_patch(Json::parse(piece));
    }
    EXPECT_EQ(nlohmann::json(whole), nlohmann::json(document));
    EXPECT_EQ(pieces.size() == 1, most > 10'000);
  }
}

}  // namespace
}  // namespace stof::host

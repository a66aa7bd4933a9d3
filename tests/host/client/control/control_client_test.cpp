#include "host/client/control/control_client.h"

#include <deque>
#include <string>

#include <gtest/gtest.h>

#include "tests/firmware/control/requests.h"
#include "tests/firmware/control/sensor.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::Sensor;
using wire::SettingsDocument;
using wire::SettingsOperation;
using wire::SettingsResult;

// A document of any length; set replaces it.
class Library final : public firmware::SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& request, std::span<const std::byte> text,
                             const firmware::Requester& /*by*/, std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override {
    ++served;
    if (request.operation == SettingsOperation::kSet) {
      document.assign(text.size(), '\0');
      std::ranges::transform(text, document.begin(),
                             [](std::byte byte) { return static_cast<char>(byte); });
      ++revision;
      answer_bytes = 0;
      return {.result = document == "bad" ? SettingsResult::kInvalid : SettingsResult::kOk,
              .restart = 1,
              .revision = revision};
    }
    if (changing) {
      ++revision;
    }
    const std::string_view rest = std::string_view(document).substr(request.offset);
    answer_bytes = std::min(rest.size(), answer_text.size());
    std::ranges::copy(std::as_bytes(std::span(rest.substr(0, answer_bytes))), answer_text.begin());
    return {.total = static_cast<std::uint16_t>(document.size() + surplus), .revision = revision};
  }

  std::string document = "{}";
  std::uint32_t revision = 1;
  bool changing = false;
  std::size_t surplus = 0;  // said, but not there
  int served = 0;
};

ControlClient open(const Sensor& sensor) {
  auto client =
      ControlClient::open("127.0.0.1:" + std::to_string(sensor.number()), {.timeout = 2s});
  if (!client) {
    ADD_FAILURE() << client.error().message;
    std::abort();
  }
  return std::move(*client);
}

TEST(ControlClient, SetsAndGetsDocumentsOfAnyLength) {
  Library library;
  Sensor sensor(&library);
  ControlClient client = open(sensor);
  for (const std::size_t size : {0U, 1U, 1151U, 1152U, 1153U, 2304U, 40'000U, 65'535U}) {
    library.document.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      library.document[i] = static_cast<char>('a' + i % 23);
    }
    const auto answer = client.request(SettingsOperation::kGet, SettingsDocument::kActive, "");
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(answer->result, SettingsResult::kOk);
    EXPECT_EQ(answer->text, library.document) << size;
  }
  const std::string text(ControlClient::kMaxText, 'z');
  const auto answer = client.request(SettingsOperation::kSet, {}, text);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(answer->revision, 2U);
  EXPECT_TRUE(answer->restart);
  EXPECT_EQ(library.document, text);
  EXPECT_EQ(client.request(SettingsOperation::kSet, {}, text + "z").error().status,
            Status::kTooLarge);
}

TEST(ControlClient, ARefusalIsAnAnswer) {
  Library library;
  Sensor sensor(&library);
  ControlClient client = open(sensor);
  EXPECT_EQ(client.request(SettingsOperation::kSet, {}, "bad").value().result,
            SettingsResult::kInvalid);
}

TEST(ControlClient, ReadsADocumentAgainThatChangesMeanwhile) {
  Library library;
  library.document.assign(3000, 'a');
  library.changing = true;
  Sensor sensor(&library);
  ControlClient client = open(sensor);
  const auto answer = client.request(SettingsOperation::kGet, {}, "");
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("changed"), std::string::npos);
  EXPECT_EQ(library.served, 6);  // three beginnings, three second parts
}

TEST(ControlClient, ADocumentThatEndsTooSoonIsAnError) {
  Library library;
  library.surplus = 1;
  Sensor sensor(&library);
  ControlClient client = open(sensor);
  EXPECT_EQ(client.request(SettingsOperation::kGet, {}, "").error().status, Status::kCorrupt);
}

TEST(ControlClient, SaysThatNobodyAnswers) {
  std::uint16_t closed = 0;
  {
    closed = Sensor().number();
  }
  auto client =
      ControlClient::open("127.0.0.1:" + std::to_string(closed), {.timeout = 5ms, .attempts = 2});
  ASSERT_TRUE(client);
  const auto answer = client->request(SettingsOperation::kSave, {}, "");
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().status, Status::kTimeout);
  EXPECT_NE(answer.error().message.find("127.0.0.1:" + std::to_string(closed)), std::string::npos);
}

// What each request is answered with; an empty list: nothing. {request id} is filled in.
class Scripted final : public ControlTransport {
 public:
  using Replies = std::vector<wire::SettingsAnswer>;
  explicit Scripted(std::deque<Replies> script) : script_(std::move(script)) {}

  Status send(std::span<const std::byte> packet) override {
    const auto parsed = wire::parse_packet(packet);
    const auto request = wire::decode_settings_request(parsed->payload);
    ++sent;
    cookies.push_back(request->cookie);
    if (script_.empty()) {
      return Status::kOk;
    }
    for (wire::SettingsAnswer answer : script_.front()) {
      answer.request_id += request->request_id;  // of the script: how far off
      std::array<std::byte, wire::kSettingsAnswerBytes> payload;
      wire::encode_settings_answer(answer, payload);
      waiting_.push_back(test::sealed(wire::PacketType::kSettingsAnswer, payload, 5));
    }
    script_.pop_front();
    return Status::kOk;
  }
  Result<Bytes> receive(Duration /*timeout*/) override {
    if (waiting_.empty()) {
      std::this_thread::sleep_for(1ms);
      return fail(Status::kTimeout);
    }
    Bytes packet = std::move(waiting_.front());
    waiting_.pop_front();
    return packet;
  }
  std::string place() const override { return "script"; }

  static inline int sent = 0;
  static inline std::vector<std::uint64_t> cookies;

 private:
  std::deque<Replies> script_;
  std::deque<Bytes> waiting_;
};

std::expected<ControlAnswer, ControlError> ask(std::deque<Scripted::Replies> script,
                                               ControlOptions options = {.timeout = 3ms}) {
  Scripted::sent = 0;
  Scripted::cookies.clear();
  ControlClient client(std::make_unique<Scripted>(std::move(script)), options);
  return client.request(SettingsOperation::kSave, {}, "");
}

constexpr wire::SettingsAnswer kOk{.result = SettingsResult::kOk, .revision = 3};

// Has packets of so many bytes, and says how long it was to wait for the last one.
class Heap final : public ControlTransport {
 public:
  explicit Heap(std::size_t packets) : left_(packets) {}
  Status send(std::span<const std::byte> /*packet*/) override { return Status::kOk; }
  Result<Bytes> receive(Duration timeout) override {
    waited = timeout;
    if (left_ == 0) {
      return fail(Status::kTimeout);
    }
    return Bytes(left_--);
  }
  std::string place() const override { return "heap"; }

  Duration waited{};

 private:
  std::size_t left_;
};

// The system may run others between a packet and the look for it.
TEST(ReceiveUntil, FindsBehindTheDeadlineWhatLiesThereAndEndsInAFlood) {
  const Time over = Time::clock::now() - 1s;
  Heap three(3);
  int behind = 0;
  for (std::size_t left = 3; left > 0; --left) {
    const auto packet = receive_until(three, over, behind);
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->size(), left);
    EXPECT_EQ(three.waited, Duration::zero());
  }
  EXPECT_EQ(receive_until(three, over, behind).error(), Status::kTimeout);
  Heap flood(1000);
  behind = 0;
  std::size_t taken = 0;
  while (receive_until(flood, over, behind)) {
    ++taken;
  }
  EXPECT_EQ(taken, 64U);
  Heap one(1);
  behind = 0;
  EXPECT_TRUE(receive_until(one, Time::clock::now() + 1h, behind));
  EXPECT_GT(one.waited, 30min);
}

TEST(ControlClient, RepeatsWhatGetsLost) {
  const auto answer = ask({{}, {}, {kOk}});
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(answer->revision, 3U);
  EXPECT_EQ(Scripted::sent, 3);
  EXPECT_FALSE(ask({{}, {}, {}, {kOk}}));
}

TEST(ControlClient, ShowsTheCookieItIsGiven) {
  EXPECT_TRUE(ask({{{.result = SettingsResult::kCookie, .cookie = 77}}, {kOk}}));
  EXPECT_EQ(Scripted::cookies, (std::vector<std::uint64_t>{0, 77}));
}

TEST(ControlClient, GivesUpOnASensorThatTakesNoCookie) {
  std::deque<Scripted::Replies> others;
  for (std::uint64_t cookie = 1; cookie <= 50; ++cookie) {
    others.push_back({{.result = SettingsResult::kCookie, .cookie = cookie}});
  }
  const auto answer = ask(others);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("another cookie whatever it is shown"), std::string::npos);
  EXPECT_EQ(Scripted::sent, 6);
}

TEST(ControlClient, ACookieThatComesLateIsNoRefusal) {
  const wire::SettingsAnswer cookie{.result = SettingsResult::kCookie, .cookie = 77};
  EXPECT_TRUE(ask({{}, {cookie}, {cookie, kOk}}));
  EXPECT_EQ(Scripted::cookies, (std::vector<std::uint64_t>{0, 0, 77}));
  const auto answer = ask({{cookie}, {cookie}, {}, {}});
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("no answer within"), std::string::npos);
}

TEST(ControlClient, SkipsAnswersToOtherRequestsAndOfOtherSensors) {
  wire::SettingsAnswer late = kOk;
  late.request_id = 0xFFFFFFFF;  // one before
  late.revision = 99;
  EXPECT_EQ(ask({{late, kOk}}).value().revision, 3U);
  EXPECT_FALSE(ask({{kOk}, {kOk}, {kOk}}, {.timeout = 3ms, .device_id = 6}));
  EXPECT_TRUE(ask({{kOk}}, {.timeout = 3ms, .device_id = 5}));
}

TEST(ControlClient, AsksABusySensorAgainAndThenSaysSo) {
  const Scripted::Replies busy{{.result = SettingsResult::kBusy}};
  EXPECT_EQ(ask({busy, {kOk}}).value().result, SettingsResult::kOk);
  EXPECT_EQ(ask({busy, busy, busy}).value().result, SettingsResult::kBusy);
}

}  // namespace
}  // namespace stof::client

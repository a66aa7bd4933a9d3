#include "firmware/keys/key_service.h"

#include <array>
#include <string>

#include <gtest/gtest.h>

#include "hal/emu/devices/store.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::keys {
namespace {

using firmware::Access;
using test::numbered_key;
using wire::SettingsOperation;
using wire::SettingsResult;

// Whoever serves settings.
class Other final : public firmware::SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& /*request*/,
                             std::span<const std::byte> /*text*/, const firmware::Requester& /*by*/,
                             std::span<std::byte> /*answer*/,
                             std::size_t& answer_bytes) noexcept override {
    ++served;
    answer_bytes = 0;
    return {};
  }
  int served = 0;
};

class KeyServiceTest : public testing::Test {
 protected:
  struct Answer {
    SettingsResult result;
    std::string text;
    std::uint16_t total;
  };
  Answer ask(SettingsOperation operation, std::string_view text, Access access,
             std::uint32_t key_id = 0, std::uint16_t offset = 0, std::size_t room = 1112) {
    std::vector<std::byte> space(room);
    std::size_t bytes = 0;
    const wire::SettingsAnswer answer =
        service_.serve({.operation = operation, .offset = offset}, std::as_bytes(std::span(text)),
                       {.peer = {}, .access = access, .key_id = key_id}, space, bytes);
    Answer out{.result = answer.result, .text = {}, .total = answer.total};
    for (const std::byte byte : std::span(space).first(bytes)) {
      out.text += static_cast<char>(byte);
    }
    return out;
  }

  Other other_;
  hal::emu::Store store_;
  Keyring ring_{&store_, nullptr};
  firmware::ChangeRing changes_;
  KeyService service_{ring_, other_, &changes_};
};

TEST_F(KeyServiceTest, LeavesEverythingElseToSettings) {
  for (const SettingsOperation operation : {SettingsOperation::kGet, SettingsOperation::kReset}) {
    static_cast<void>(ask(operation, "", Access::kRead));
  }
  EXPECT_EQ(other_.served, 2);
}

TEST_F(KeyServiceTest, ListsKeysForAnAdminInPartsAndNoSecrets) {
  EXPECT_EQ(ask(SettingsOperation::kKeys, "", Access::kAdmin).text, "[]");
  for (std::uint32_t id = 1; id <= kMostKeys; ++id) {
    ASSERT_EQ(ring_.add(numbered_key(id, wire::Role::kTune)), Status::kOk);
  }
  const Answer whole = ask(SettingsOperation::kKeys, "", Access::kAdmin, 0, 0, 4000);
  EXPECT_EQ(whole.text.size(), whole.total);
  EXPECT_EQ(whole.text.substr(0, 58), R"([{"id": "00000001", "role": "tune", "name": "test"},)"
                                      "\n{\"id\"");
  std::string parts;
  while (parts.size() < whole.total) {
    parts += ask(SettingsOperation::kKeys, "", Access::kAdmin, 0,
                 static_cast<std::uint16_t>(parts.size()), 100)
                 .text;
  }
  EXPECT_EQ(parts, whole.text);
  for (const Access access : {Access::kRead, Access::kHarmless, Access::kTune}) {
    EXPECT_EQ(ask(SettingsOperation::kKeys, "", access).result, SettingsResult::kDenied);
  }
}

TEST_F(KeyServiceTest, AKeyIsEndedByAnAdminOrByItself) {
  for (std::uint32_t id = 1; id <= 3; ++id) {
    ASSERT_EQ(ring_.add(numbered_key(id)), Status::kOk);
  }
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000002", Access::kTune, 1).result,
            SettingsResult::kDenied);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000001", Access::kHarmless).result,
            SettingsResult::kDenied);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000000", Access::kHarmless, 0).result,
            SettingsResult::kDenied);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000001", Access::kRead, 1).result,
            SettingsResult::kOk);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000002", Access::kAdmin, 3).result,
            SettingsResult::kOk);
  ASSERT_EQ(ring_.keys().count(), 1U);
  EXPECT_EQ(ring_.keys().all()[0].id, 3U);
}

TEST_F(KeyServiceTest, TellsWhichKeyHasEndedAndWhenItWasTheLast) {
  ASSERT_EQ(ring_.add(numbered_key(7, wire::Role::kTune)), Status::kOk);
  ASSERT_EQ(ring_.add(numbered_key(8)), Status::kOk);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000007", Access::kTune, 7).result,
            SettingsResult::kOk);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000007", Access::kAdmin).result,
            SettingsResult::kInvalid);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000008", Access::kAdmin).result,
            SettingsResult::kOk);
  const auto first = changes_.pop();
  const auto last = changes_.pop();
  ASSERT_TRUE(first && last);
  EXPECT_EQ(first->kind, firmware::EventKind::kKeyEnded);
  EXPECT_EQ(first->value, 7U);
  EXPECT_EQ(first->role, wire::Role::kTune);
  EXPECT_EQ(last->kind, firmware::EventKind::kLastKeyEnded);
  EXPECT_EQ(last->value, 8U);
  EXPECT_EQ(changes_.size(), 0U);
}

TEST_F(KeyServiceTest, SaysWhatItDoesNotEnd) {
  ASSERT_EQ(ring_.add(numbered_key(1)), Status::kOk);
  for (const char* const id :
       {"", "1", "00000002", "0000000g", "000000011", "+0000001", "00000000"}) {
    const Answer answer = ask(SettingsOperation::kUnpair, id, Access::kAdmin);
    EXPECT_EQ(answer.result, SettingsResult::kInvalid) << id;
    EXPECT_NE(answer.text.find("unpair: there is no key"), std::string::npos);
  }
  store_.break_down(true);
  EXPECT_EQ(ask(SettingsOperation::kUnpair, "00000001", Access::kAdmin).result,
            SettingsResult::kNotSaved);
  EXPECT_EQ(ring_.keys().count(), 1U);
}

}  // namespace
}  // namespace stof::keys

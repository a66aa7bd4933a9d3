#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/settings/fields/document.h"
#include "firmware/settings/settings_server.h"
#include "hal/emu/devices/network_interfaces.h"
#include "hal/emu/devices/store.h"

namespace stof::settings {

using Operation = wire::SettingsOperation;
using Document = wire::SettingsDocument;
using Result = wire::SettingsResult;

class Board final : public Limits, public SettingsSink {
 public:
  bool accepts(const Settings& settings, PagedWriter& why) noexcept override {
    if (settings.depth.disparities > 128) {
      why << "too many disparities";
      return false;
    }
    return true;
  }
  bool apply(const Settings& settings, std::uint32_t revision) noexcept override {
    if (busy) {
      return false;
    }
    applied = settings;
    applied_revision = revision;
    ++applications;
    return true;
  }

  bool busy = false;
  Settings applied{};
  std::uint32_t applied_revision = 0;
  int applications = 0;
};

struct Answer {
  Result result;
  std::string text;
  wire::SettingsAnswer fields;
};

class SettingsServerTest : public testing::Test {
 protected:
  Answer ask(Operation operation, const std::string& text = "", Document document = {},
             std::uint16_t offset = 0, std::size_t room = 1024) {
    std::vector<std::byte> space(room);
    std::size_t bytes = 0;
    const wire::SettingsAnswer answer = server_.serve(
        {.operation = operation, .document = document, .offset = offset},
        std::as_bytes(std::span(text)),
        {.peer = peer_, .now = now_, .access = access_, .key_id = key_id_}, space, bytes);
    EXPECT_LE(bytes, room);
    std::string said(bytes, '\0');
    std::transform(space.begin(), space.begin() + static_cast<std::ptrdiff_t>(bytes), said.begin(),
                   [](std::byte byte) { return static_cast<char>(byte); });
    return {answer.result, said, answer};
  }

  std::string read(Document document, std::size_t room = 1024) {
    std::string text;
    while (true) {
      const Answer part =
          ask(Operation::kGet, "", document, static_cast<std::uint16_t>(text.size()), room);
      EXPECT_EQ(part.result, Result::kOk);
      text += part.text;
      if (part.text.empty() || text.size() >= part.fields.total) {
        EXPECT_EQ(text.size(), part.fields.total);
        return text;
      }
    }
  }

  Settings settings_of(Document document) {
    Settings settings;
    std::array<char, kWhyBytes> space;
    PagedWriter why(space);
    EXPECT_TRUE(parse(read(document), settings, why)) << why.text();
    return settings;
  }

  hal::emu::Store store_;
  hal::emu::Store good_;
  hal::emu::Store trial_;
  hal::emu::Store fixed_;
  firmware::ChangeRing changes_;
  Board board_;
  hal::Peer peer_{.address = {1, 2, 3}, .port = 4};
  hal::Time now_{std::chrono::seconds(1)};
  firmware::Access access_ = firmware::Access::kAdmin;
  std::uint32_t key_id_ = 0xABC;
  hal::emu::NetworkInterfaces interfaces_;
  SettingsServer server_{Settings{},
                         Settings{},
                         {.limits = board_,
                          .sink = board_,
                          .store = &store_,
                          .fixed = &fixed_,
                          .changes = &changes_,
                          .interfaces = &interfaces_}};
};

}  // namespace stof::settings

#include "hal/linux/system/file_store.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/power_cut.h"

namespace stof::hal::linux {
namespace {

using stof::test::power;

class FileStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / "stof_file_store_XXXXXX";
    std::string name = folder_.string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    file_ = (folder_ / "settings.json").string();
    power = {};
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static Status save(FileStore& store, const std::string& text) {
    return store.save(std::as_bytes(std::span(text)));
  }

  // After a power cut: what was renamed before it was flushed is lost.
  std::string after_power_cut() {
    if (power.unflushed == file_) {
      std::ofstream(file_, std::ios::trunc).close();
    }
    power = {};
    return read(file_);
  }

  static std::string read(const std::string& name) {
    FileStore store(name);
    std::vector<std::byte> space(10'000);
    const Result<std::optional<std::size_t>> bytes = store.load(space);
    EXPECT_TRUE(bytes);
    return {reinterpret_cast<const char*>(space.data()), bytes.value_or(0).value_or(0)};
  }

  std::filesystem::path folder_;
  std::string file_;
};

TEST_F(FileStoreTest, LoadsWhatWasSaved) {
  FileStore store(file_);
  EXPECT_EQ(read(file_), "");
  EXPECT_EQ(save(store, "one"), Status::kOk);
  EXPECT_EQ(read(file_), "one");
  EXPECT_EQ(save(store, std::string(5000, 'x')), Status::kOk);
  EXPECT_EQ(read(file_), std::string(5000, 'x'));
  EXPECT_EQ(save(store, ""), Status::kOk);
  EXPECT_EQ(read(file_), "");
}

TEST_F(FileStoreTest, PowerCutAtEveryCallLeavesOldOrNew) {
  const std::string before(3000, 'a');
  const std::string after(4000, 'b');
  FileStore store(file_);
  ASSERT_EQ(save(store, before), Status::kOk);
  power = {};
  ASSERT_EQ(save(store, after), Status::kOk);
  const int calls = power.calls;
  ASSERT_GE(calls, 5);  // unlink, write, fsync, rename, fsync of the folder
  bool old_seen = false;
  for (int cut = 0; cut < calls; ++cut) {
    ASSERT_EQ(save(store, before), Status::kOk);
    power = {};
    power.calls_left = cut;
    EXPECT_EQ(save(store, after), Status::kDeviceError) << "call " << cut;
    const std::string left = after_power_cut();
    EXPECT_TRUE(left == before || left == after) << "call " << cut << ": " << left.size();
    old_seen = old_seen || left == before;
  }
  EXPECT_TRUE(old_seen);
}

TEST_F(FileStoreTest, SetAsideIsKeptAndNotLoaded) {
  FileStore store(file_);
  ASSERT_EQ(save(store, "damaged"), Status::kOk);
  EXPECT_EQ(store.set_aside(), Status::kOk);
  EXPECT_EQ(read(file_), "");
  EXPECT_EQ(read(file_ + ".bad"), "damaged");
  EXPECT_EQ(store.set_aside(), Status::kDeviceError);
}

TEST_F(FileStoreTest, SaysWhatFails) {
  FileStore store(file_);
  ASSERT_EQ(save(store, "12345"), Status::kOk);
  std::array<std::byte, 5> exact{};
  EXPECT_EQ(store.load(exact).value(), 5U);
  EXPECT_EQ(store.load(std::span(exact).first(4)).error(), Status::kTooLarge);
  FileStore nowhere((folder_ / "none" / "x.json").string());
  EXPECT_EQ(nowhere.load(exact).value(), std::nullopt);
  EXPECT_EQ(save(nowhere, "a"), Status::kDeviceError);
  EXPECT_FALSE(std::filesystem::exists(file_ + ".new"));
}

// Whoever names a folder, a device or a link by mistake finds it as it was.
TEST_F(FileStoreTest, WhatIsNoRegularFileIsLeftAlone) {
  std::filesystem::create_directory(folder_ / "folder");
  std::ofstream(folder_ / "target") << "kept";
  std::filesystem::create_symlink(folder_ / "target", folder_ / "link");
  std::filesystem::create_symlink(folder_ / "nowhere", folder_ / "broken");
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);  // whoever opens it would wait
  const auto entries = [this] {
    std::map<std::string, std::filesystem::file_type> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      found[entry.path().filename().string()] = entry.symlink_status().type();
    }
    return found;
  };
  const auto before = entries();
  for (const std::string name : {"folder", "link", "broken", "pipe"}) {
    FileStore store((folder_ / name).string());
    std::array<std::byte, 10> space{};
    EXPECT_EQ(store.load(space).error(), Status::kUnsupported) << name;
    EXPECT_EQ(save(store, "new"), Status::kUnsupported) << name;
    EXPECT_EQ(store.set_aside(), Status::kUnsupported) << name;
  }
  FileStore device("/dev/null");
  std::array<std::byte, 10> space{};
  EXPECT_EQ(device.load(space).error(), Status::kUnsupported);
  EXPECT_EQ(save(device, "new"), Status::kUnsupported);
  EXPECT_EQ(entries(), before);
  EXPECT_EQ(read((folder_ / "target").string()), "kept");
}

// Nor is what has the name of one of its helpers.
TEST_F(FileStoreTest, HelpersReplaceNoLinkAndNoFolder) {
  FileStore store(file_);
  ASSERT_EQ(save(store, "old"), Status::kOk);
  std::ofstream(folder_ / "target") << "kept";
  std::filesystem::create_symlink(folder_ / "target", file_ + ".new");
  EXPECT_EQ(save(store, "new"), Status::kDeviceError);
  std::filesystem::create_symlink(folder_ / "target", file_ + ".bad");
  EXPECT_EQ(store.set_aside(), Status::kDeviceError);
  EXPECT_EQ(read(file_), "old");
  EXPECT_EQ(read((folder_ / "target").string()), "kept");
  EXPECT_TRUE(std::filesystem::is_symlink(file_ + ".new"));
  EXPECT_TRUE(std::filesystem::is_symlink(file_ + ".bad"));
}

TEST_F(FileStoreTest, AnEmptyFileIsNotNone) {
  FileStore store(file_);
  std::array<std::byte, 10> space{};
  EXPECT_EQ(store.load(space).value(), std::nullopt);
  std::ofstream(file_).close();
  EXPECT_EQ(store.load(space).value(), 0U);
}

TEST_F(FileStoreTest, WhatCannotBeReadStaysWhereItIs) {
  constexpr uid_t kNobody = 65'534;
  const bool root = geteuid() == 0;  // who reads every file
  if (root) {
    std::filesystem::permissions(folder_, std::filesystem::perms::all);
    ASSERT_EQ(seteuid(kNobody), 0);
  }
  FileStore store(file_);
  ASSERT_EQ(save(store, "secret"), Status::kOk);
  std::filesystem::permissions(file_, std::filesystem::perms::none);
  std::array<std::byte, 10> space{};
  EXPECT_EQ(store.load(space).error(), Status::kDeviceError);
  EXPECT_EQ(save(store, "new"), Status::kDeviceError);
  EXPECT_EQ(store.set_aside(), Status::kDeviceError);
  std::filesystem::permissions(file_, std::filesystem::perms::owner_read);
  EXPECT_EQ(read(file_), "secret");
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
}

TEST_F(FileStoreTest, LongNamesAreUsedWholeOrRefused) {
  std::filesystem::path deep = folder_;
  for (int i = 0; i < 6; ++i) {
    deep /= std::string(60, 'd');
  }
  std::filesystem::create_directories(deep);
  FileStore store((deep / "settings.json").string());
  EXPECT_EQ(save(store, "deep"), Status::kOk);
  EXPECT_EQ(read((deep / "settings.json").string()), "deep");
  FileStore too_long((folder_ / std::string(300, 'n')).string());
  std::array<std::byte, 5> space{};
  EXPECT_EQ(too_long.load(space).error(), Status::kDeviceError);
  EXPECT_EQ(save(too_long, "a"), Status::kDeviceError);
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) {
    ++entries;
  }
  EXPECT_EQ(entries, 1U);  // the folder, and no file of a name that was cut
}

}  // namespace
}  // namespace stof::hal::linux

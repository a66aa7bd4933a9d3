#include "hal/linux/system/file_store.h"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

// The linker leads open, write, fsync and rename here, so that power can be cut before each of
// them.
namespace {

struct Power {
  int calls_left = -1;  // -1: power stays on
  int calls = 0;
  bool cut = false;
  bool flushed = true;      // what was written last
  std::string unflushed{};  // name that rename gave to bytes not flushed yet
} power;

// Whether the call still happens.
bool spend() {
  ++power.calls;
  if (power.calls_left == 0) {
    power.cut = true;
  } else if (power.calls_left > 0) {
    --power.calls_left;
  }
  return !power.cut;
}

}  // namespace

extern "C" {
ssize_t __real_write(int fd, const void* bytes, size_t count);
int __real_fsync(int fd);
int __real_rename(const char* from, const char* to);

ssize_t __wrap_write(int fd, const void* bytes, size_t count) {
  if (fd <= 2) {
    return __real_write(fd, bytes, count);
  }
  const bool on = spend();
  power.flushed = false;
  if (on) {
    return __real_write(fd, bytes, count);
  }
  static_cast<void>(__real_write(fd, bytes, count / 2));  // torn
  errno = EIO;
  return -1;
}

int __wrap_fsync(int fd) {
  if (!spend()) {
    errno = EIO;
    return -1;
  }
  power.flushed = true;
  return __real_fsync(fd);
}

int __wrap_rename(const char* from, const char* to) {
  if (!spend()) {
    errno = EIO;
    return -1;
  }
  if (!power.flushed) {
    power.unflushed = to;
  }
  return __real_rename(from, to);
}
}

namespace stof::hal::linux {
namespace {

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
    const Result<std::size_t> bytes = store.load(space);
    EXPECT_TRUE(bytes);
    return {reinterpret_cast<const char*>(space.data()), bytes.value_or(0)};
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
  ASSERT_GE(calls, 4);  // write, fsync, rename, fsync of the folder
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
  EXPECT_EQ(store.load(exact).value_or(0), 5U);
  EXPECT_EQ(store.load(std::span(exact).first(4)).error(), Status::kTooLarge);
  FileStore folder(folder_.string());
  EXPECT_EQ(folder.load(exact).error(), Status::kDeviceError);
  FileStore nowhere((folder_ / "none" / "x.json").string());
  EXPECT_EQ(nowhere.load(exact).value_or(9), 0U);
  EXPECT_EQ(save(nowhere, "a"), Status::kDeviceError);
  EXPECT_FALSE(std::filesystem::exists(file_ + ".new"));
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

#include "hal/linux/system/file_slots.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace stof::hal::linux {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

class FileSlotsTest : public testing::Test {
 protected:
  FileSlotsTest() {
    std::string folder = (std::filesystem::temp_directory_path() / "stof_slots_XXXXXX").string();
    EXPECT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    for (int part = 1; part <= 3; ++part) {
      make(part, 4096 * static_cast<std::size_t>(part));
    }
  }
  ~FileSlotsTest() override { std::filesystem::remove_all(folder_); }

  std::string prefix() const { return (folder_ / "card").string(); }
  void make(int part, std::size_t bytes) const {
    std::ofstream file(prefix() + std::to_string(part), std::ios::binary);
    file << std::string(bytes, static_cast<char>('0' + part));
  }
  // Until the write that is under way has ended.
  static Status wait(FileSlots& slots) {
    Status status = slots.progress();
    for (int i = 0; i < 30'000 && status == Status::kTimeout; ++i) {
      std::this_thread::sleep_for(1ms);
      status = slots.progress();
    }
    return status;
  }

  std::filesystem::path folder_;
};

TEST_F(FileSlotsTest, WritesAPartAndLeavesTheOthers) {
  auto slots = FileSlots::open(prefix());
  ASSERT_TRUE(slots);
  EXPECT_EQ((*slots)->bytes(DiskPart::kBoot), 4096);
  EXPECT_EQ((*slots)->bytes(DiskPart::kSlotB), 3 * 4096);
  EXPECT_EQ((*slots)->progress(), Status::kOk);
  const Bytes bytes(1000, std::byte{0x5A});
  (*slots)->write(DiskPart::kSlotA, 512, bytes);
  EXPECT_EQ(wait(**slots), Status::kOk);
  Bytes found(4096 * 2);
  ASSERT_EQ((*slots)->read(DiskPart::kSlotA, 0, found), Status::kOk);
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i], i >= 512 && i < 1512 ? std::byte{0x5A} : std::byte{'2'}) << i;
  }
  Bytes other(4096);
  ASSERT_EQ((*slots)->read(DiskPart::kBoot, 0, other), Status::kOk);
  EXPECT_EQ(other, Bytes(4096, std::byte{'1'}));
}

TEST_F(FileSlotsTest, NothingIsWrittenOrReadOutsideOfAPart) {
  auto slots = FileSlots::open(prefix());
  ASSERT_TRUE(slots);
  Bytes bytes(512);
  for (const std::size_t offset : {std::size_t{4096 - 511}, std::size_t{4097}, ~std::size_t{0}}) {
    (*slots)->write(DiskPart::kBoot, offset, bytes);
    EXPECT_EQ(wait(**slots), Status::kInvalidArgument);
    EXPECT_EQ((*slots)->read(DiskPart::kBoot, offset, bytes), Status::kInvalidArgument);
  }
  EXPECT_EQ(std::filesystem::file_size(prefix() + "1"), 4096);
}

TEST_F(FileSlotsTest, WhatIsNoDiskIsNotOpened) {
  EXPECT_EQ(FileSlots::open(prefix() + "x").error(), Status::kDeviceError);
  make(3, 1000);  // no whole sectors
  EXPECT_EQ(FileSlots::open(prefix()).error(), Status::kDeviceError);
  std::filesystem::remove(prefix() + "3");
  std::filesystem::create_symlink("/dev/null", prefix() + "3");
  EXPECT_EQ(FileSlots::open(prefix()).error(), Status::kUnsupported);
}

TEST_F(FileSlotsTest, TheLastWriteIsEndedBeforeItEnds) {
  const Bytes bytes(4096, std::byte{7});
  {
    auto slots = FileSlots::open(prefix());
    ASSERT_TRUE(slots);
    (*slots)->write(DiskPart::kSlotB, 4096, bytes);
  }
  std::ifstream file(prefix() + "3", std::ios::binary);
  file.seekg(4096);
  EXPECT_EQ(file.get(), 7);
}

}  // namespace
}  // namespace stof::hal::linux

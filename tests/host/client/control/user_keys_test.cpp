#include "host/client/control/user_keys.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/firmware/keys/some_keys.h"

namespace stof::client {
namespace {

using test::numbered_key;

class UserKeysTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "stof_user_keys_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder_.data()), nullptr);
    file_ = folder_ + "/a/b/keys";
    old_mask_ = ::umask(0);  // nothing helps
  }
  void TearDown() override {
    ::umask(old_mask_);
    std::filesystem::remove_all(folder_);
  }
  static mode_t mode(const std::string& name) {
    struct stat found{};
    EXPECT_EQ(::stat(name.c_str(), &found), 0);
    return found.st_mode & 0777U;
  }
  std::string refusal() const {
    const auto read = read_user_keys(file_);
    return read ? "" : read.error().message;
  }

  std::string folder_;
  std::string file_;
  mode_t old_mask_ = 0;
};

TEST_F(UserKeysTest, NoFileIsNoKey) {
  EXPECT_EQ(read_user_keys(file_).value().count(), 0U);
  EXPECT_EQ(read_user_keys(folder_ + "/none").value().count(), 0U);
}

TEST_F(UserKeysTest, AreForTheirOwnerAlone) {
  ASSERT_TRUE(add_user_key(file_, numbered_key(1)));
  EXPECT_EQ(mode(file_), 0600U);
  EXPECT_EQ(mode(folder_ + "/a"), 0700U);
  EXPECT_EQ(mode(folder_ + "/a/b"), 0700U);
  EXPECT_FALSE(std::filesystem::exists(file_ + ".new"));
  for (const mode_t others : {0640U, 0604U, 0602U}) {
    ASSERT_EQ(::chmod(file_.c_str(), others), 0);
    EXPECT_NE(refusal().find("others may read these keys: chmod 600"), std::string::npos);
  }
}

TEST_F(UserKeysTest, ANewSecretReplacesTheOldAndNothingElseGoes) {
  wire::Key other = numbered_key(2);
  other.device = 9;
  ASSERT_TRUE(add_user_key(file_, numbered_key(1)));
  ASSERT_TRUE(add_user_key(file_, other));
  ASSERT_TRUE(add_user_key(file_, numbered_key(3)));  // another sensor may have that number too
  wire::Key renewed = numbered_key(1);
  renewed.secret[0] ^= std::byte{1};
  ASSERT_TRUE(add_user_key(file_, renewed));
  const wire::KeyTable keys = read_user_keys(file_).value();
  ASSERT_EQ(keys.count(), 3U);
  EXPECT_EQ(keys.all()[0], other);
  EXPECT_EQ(keys.all()[1], numbered_key(3));
  EXPECT_EQ(keys.all()[2], renewed);
  other.device = 10;
  EXPECT_EQ(add_user_key(file_, other).error().status, Status::kInvalidArgument);
}

TEST_F(UserKeysTest, ManyAtATimeLoseNone) {
  std::vector<std::thread> programs;
  for (std::uint32_t i = 1; i <= 16; ++i) {
    programs.emplace_back([this, i] { EXPECT_TRUE(add_user_key(file_, numbered_key(i))) << i; });
  }
  for (std::thread& program : programs) {
    program.join();
  }
  EXPECT_EQ(read_user_keys(file_).value().count(), 16U);
}

TEST_F(UserKeysTest, AFolderThatEverybodyWritesIsRefused) {
  ASSERT_TRUE(add_user_key(file_, numbered_key(1)));
  ASSERT_EQ(::chmod((folder_ + "/a/b").c_str(), 0777), 0);
  EXPECT_NE(refusal().find("chmod o-w"), std::string::npos);
  ASSERT_EQ(::chmod((folder_ + "/a/b").c_str(), 01777), 0);  // sticky, as /tmp
  EXPECT_EQ(refusal(), "");
}

TEST_F(UserKeysTest, WhatIsNoKeyFileIsNeverReplaced) {
  ASSERT_TRUE(write_user_keys(file_, {}));
  std::ofstream(file_, std::ios::trunc) << "notes\n";
  EXPECT_NE(refusal().find("no key file, or damaged"), std::string::npos);
  EXPECT_EQ(add_user_key(file_, numbered_key(1)).error().status, Status::kCorrupt);
  std::ifstream kept(file_);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(kept), {}), "notes\n");
  std::filesystem::remove(file_);
  std::filesystem::create_directory(file_);
  EXPECT_NE(refusal().find("no regular file"), std::string::npos);
  EXPECT_FALSE(write_user_keys(file_, {}));
}

TEST_F(UserKeysTest, SaysWhereItCannotBeWritten) {
  EXPECT_NE(write_user_keys("/proc/keys_of_nobody/keys", {}).error().message.find("folder"),
            std::string::npos);
  EXPECT_FALSE(write_user_keys("", {}));
}

}  // namespace
}  // namespace stof::client

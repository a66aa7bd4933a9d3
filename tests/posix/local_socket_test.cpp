#include "posix/local_socket.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>

namespace stof::posix {
namespace {

class LocalSocketTest : public testing::Test {
 protected:
  LocalSocketTest() {
    std::string name = (std::filesystem::temp_directory_path() / "stof_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    path_ = (folder_ / "socket").string();
  }
  ~LocalSocketTest() override { std::filesystem::remove_all(folder_); }
  LocalSocketTest(const LocalSocketTest&) = delete;
  LocalSocketTest& operator=(const LocalSocketTest&) = delete;

  std::filesystem::path folder_;
  std::string path_;
};

TEST_F(LocalSocketTest, AsksAndAnswersForThisUserAlone) {
  const auto server = LocalSocket::serve(path_);
  ASSERT_TRUE(server) << server.error();
  struct stat there{};
  ASSERT_EQ(stat(path_.c_str(), &there), 0);
  EXPECT_EQ(there.st_mode & 0777U, 0600U);
  const auto client = LocalSocket::connect(path_);
  const auto other = LocalSocket::connect(path_);
  ASSERT_TRUE(client && other);
  std::array<char, 8> space{};
  EXPECT_EQ(server->receive(space).error(), EAGAIN);
  EXPECT_EQ(client->send("question"), 0);
  LocalSocket::Peer from;
  const auto size = server->receive(space, &from);
  ASSERT_TRUE(size);
  EXPECT_EQ(std::string(space.data(), *size), "question");
  EXPECT_EQ(server->answer(from, "yes"), 0);
  EXPECT_EQ(other->receive(space).error(), EAGAIN);
  const auto answered = client->receive(space);
  ASSERT_TRUE(answered);
  EXPECT_EQ(std::string(space.data(), *answered), "yes");
}

TEST_F(LocalSocketTest, WhatSomebodyServesOrIsNoSocketIsLeftAlone) {
  {
    const auto server = LocalSocket::serve(path_);
    ASSERT_TRUE(server);
    EXPECT_EQ(LocalSocket::serve(path_).error(), EADDRINUSE);
  }
  EXPECT_EQ(LocalSocket::connect(path_).error(), ECONNREFUSED);
  EXPECT_TRUE(LocalSocket::serve(path_));  // that nobody serves any more
  const std::string file = (folder_ / "file").string();
  std::ofstream(file) << "text";
  EXPECT_EQ(LocalSocket::serve(file).error(), EEXIST);
  EXPECT_EQ(std::filesystem::file_size(file), 4U);
  EXPECT_EQ(LocalSocket::serve(std::string(200, 'x')).error(), ENAMETOOLONG);
  EXPECT_EQ(LocalSocket::connect((folder_ / "none").string()).error(), ENOENT);
}

}  // namespace
}  // namespace stof::posix

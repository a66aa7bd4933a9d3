#include "dataset/files/file.h"

#include <csignal>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "tests/dataset/scratch.h"

namespace stof::dataset {
namespace {

class WriteWhole : public test::Scratch {};

TEST_F(WriteWhole, ReplacesAnOlderFile) {
  const auto file = put("a", "longer than what comes");
  ASSERT_TRUE(write_whole(file, "new"));
  EXPECT_EQ(read_whole(file, 100), "new");
}

TEST_F(WriteWhole, FollowsNoLinkAndWaitsAtNoPipe) {
  const auto target = put("target", "kept");
  std::filesystem::create_symlink(target, folder() / "link");
  std::filesystem::create_symlink(folder() / "absent", folder() / "dangling");
  ASSERT_EQ(::mkfifo((folder() / "pipe").c_str(), 0600), 0);
  for (const char* const name : {"link", "dangling", "pipe"}) {
    const auto written = write_whole(folder() / name, "x");
    ASSERT_FALSE(written) << name;
    test::expect_one_line_about(written.error().message, folder() / name, "cannot be written");
  }
  EXPECT_EQ(read_whole(target, 100), "kept");
  EXPECT_FALSE(is_there(folder() / "absent"));
}

TEST_F(WriteWhole, LeavesNoPartOnAFullDisk) {
  const auto file = put("a", "kept");
  ::chmod(file.c_str(), 0600);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 1000;
  const auto action = std::signal(SIGXFSZ, SIG_IGN);  // then write() says so
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto over = write_whole(file, std::string(5000, 'x'));
  const auto fresh = write_whole(folder() / "b", std::string(5000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, action);
  ASSERT_FALSE(over);
  test::expect_one_line_about(over.error().message, file, "the disk is full");
  ASSERT_FALSE(fresh);
  EXPECT_EQ(read_whole(file, 100), "kept");
  const std::filesystem::directory_iterator all(folder());
  EXPECT_EQ(std::distance(begin(all), end(all)), 1);  // no part of either under another name
  ASSERT_TRUE(write_whole(file, std::string(5000, 'x')));
  EXPECT_EQ(std::filesystem::status(file).permissions(), std::filesystem::perms(0600));
}

TEST_F(WriteWhole, WritesInAFolderThatTakesNoNewName) {
  const auto file = put("a", "old");
  std::filesystem::permissions(folder(), std::filesystem::perms(0555));
  const auto written = write_whole(file, "new");
  std::filesystem::permissions(folder(), std::filesystem::perms(0755));
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(read_whole(file, 100), "new");
}

TEST_F(WriteWhole, SaysWhenTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) {
    GTEST_SKIP() << "no /dev/full here";
  }
  const auto written = write_whole("/dev/full", "x");
  ASSERT_FALSE(written);
  test::expect_one_line_about(written.error().message, "/dev/full", "the disk is full");
}

}  // namespace
}  // namespace stof::dataset

#include "dataset/files/file.h"

#include <gtest/gtest.h>
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

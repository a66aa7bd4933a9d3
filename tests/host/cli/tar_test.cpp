#include "host/cli/sensor/tar.h"

#include <string>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

TEST(Tar, HasTheFieldsOfAUstarHeader) {
  Tar tar(0);
  tar.add("folder/a.txt", "hello");
  const std::string bytes = tar.take();
  ASSERT_EQ(bytes.size(), 4U * 512);  // header, one block, two of the end
  EXPECT_EQ(bytes.substr(0, 13), std::string("folder/a.txt", 13));
  EXPECT_EQ(bytes.substr(100, 8), std::string("0000644", 8));
  EXPECT_EQ(bytes.substr(124, 12), std::string("00000000005", 12));
  EXPECT_EQ(bytes.substr(257, 8), std::string("ustar\0"
                                              "00",
                                              8));
  EXPECT_EQ(bytes.substr(512, 5), "hello");
  unsigned sum = 0;
  for (std::size_t i = 0; i < 512; ++i) {
    const bool checksum = i >= 148 && i < 156;
    sum += checksum ? ' ' : static_cast<unsigned char>(bytes[i]);
  }
  EXPECT_EQ(std::stoul(bytes.substr(148, 6), nullptr, 8), sum);
  EXPECT_EQ(bytes.substr(1024), std::string(1024, '\0'));
}

TEST(Tar, FillsNoBlockThatIsFull) {
  Tar tar(1);
  tar.add("a", std::string(512, 'x'));
  tar.add("b", "");
  EXPECT_EQ(tar.take().size(), 512U * (2 + 1 + 2));
}

}  // namespace
}  // namespace stof::host

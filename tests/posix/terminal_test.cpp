#include "posix/terminal.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace stof::posix {
namespace {

TEST(Terminal, CarriesEveryByteAsItIs) {
  std::string name;
  const auto far = open_pseudo_terminal(name);
  if (!far) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  const auto line = open_line(name.c_str());
  ASSERT_TRUE(line);
  ASSERT_EQ(make_raw(line->get(), {.baud = 921'600}), 0);
  EXPECT_FALSE(has_flow_control(line->get()));
  std::array<unsigned char, 256> sent{};
  for (std::size_t i = 0; i < sent.size(); ++i) {
    sent[i] = static_cast<unsigned char>(i);
  }
  ASSERT_EQ(write(far->get(), sent.data(), sent.size()), 256);
  std::array<unsigned char, 256> got{};
  ASSERT_EQ(read(line->get(), got.data(), got.size()), 256);
  EXPECT_EQ(got, sent);
  EXPECT_EQ(read(line->get(), got.data(), got.size()), -1);  // does not block
  EXPECT_EQ(errno, EAGAIN);
}

TEST(Terminal, TakesFlowControlAndSpeedsWithoutAName) {
  std::string name;
  const auto far = open_pseudo_terminal(name);
  if (!far) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  const auto line = open_line(name.c_str());
  ASSERT_TRUE(line);
  ASSERT_EQ(make_raw(line->get(), {.baud = 115'200, .flow_control = true}), 0);
  EXPECT_TRUE(has_flow_control(line->get()));
  EXPECT_EQ(make_raw(line->get(), {.baud = 123'456}), has_any_speed(line->get()) ? 0 : EINVAL);
}

TEST(Terminal, RefusesWhatIsNoLine) {
  EXPECT_EQ(open_line("/dev/no-such-line").error(), ENOENT);
  const auto file = open_line("/dev/null");
  ASSERT_TRUE(file);
  EXPECT_EQ(make_raw(file->get(), {}), ENOTTY);
}

}  // namespace
}  // namespace stof::posix

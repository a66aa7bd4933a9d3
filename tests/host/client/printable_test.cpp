#include "host/client/printable.h"

#include <gtest/gtest.h>

namespace stof::client {
namespace {

TEST(Printable, TextStaysAsItIs) {
  EXPECT_EQ(printable("front (A17)"), "front (A17)");
  EXPECT_EQ(printable("Gr\xc3\xbc\xc3\x9f \xe6\xb7\xb1\xe5\xba\xa6 \xf0\x9f\xa4\x96"),
            "Gr\xc3\xbc\xc3\x9f \xe6\xb7\xb1\xe5\xba\xa6 \xf0\x9f\xa4\x96");
}

TEST(Printable, WhatControlsATerminalDoesNot) {
  EXPECT_EQ(printable("a\x1b[2Jb\x7f"), "a?[2Jb?");
  EXPECT_EQ(printable("\xc2\x9b"), "??");
  EXPECT_EQ(printable("a\nb"), "a?b");
  EXPECT_EQ(printable("a\nb\r", Lines::kSeveral), "a\nb?");
}

TEST(Printable, WhatHidesOrTurnsTheDirectionOfWritingDoesNot) {
  EXPECT_EQ(printable("\xe2\x80\xae"), "???");           // right-to-left override
  EXPECT_EQ(printable("\xe2\x80\x8b"), "???");           // zero width space
  EXPECT_EQ(printable("\xe2\x81\xa6"), "???");           // left-to-right isolate
  EXPECT_EQ(printable("\xef\xbb\xbf."), "???.");         // byte order mark
  EXPECT_EQ(printable("\xe2\x80\x94"), "\xe2\x80\x94");  // a dash
}

TEST(Printable, WhatIsNoUtf8DoesNot) {
  EXPECT_EQ(printable("\xff\xc0\xaf\xed\xa0\x80\xf5"), "???????");
  EXPECT_EQ(printable("\xe2\x80"), "??");
}

}  // namespace
}  // namespace stof::client

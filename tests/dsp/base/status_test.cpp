#include "dsp/base/status.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

TEST(Status, EveryStatusHasItsOwnName) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(Status::kUnsupported); ++i) {
    names.insert(to_string(static_cast<Status>(i)));
  }
  EXPECT_EQ(names.size(), 9U);
}

}  // namespace
}  // namespace stof::dsp

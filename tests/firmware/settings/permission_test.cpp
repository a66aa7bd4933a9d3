#include "firmware/settings/permission.h"

#include <array>
#include <string>

#include <gtest/gtest.h>

#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/field.h"
#include "firmware/settings/fields/field_value.h"

namespace stof::settings {
namespace {

// "": it is permitted.
std::string refusal(const Settings& active, const Settings& next, Access access) {
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  return permitted(active, next, access, why) ? "" : std::string(why.text());
}

Settings changed(std::string_view json, Settings from = {}) {
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  EXPECT_TRUE(parse(json, from, why)) << why.text();
  return from;
}

// Another value of the field, which the table takes.
Settings with_other(const Field& field) {
  Settings next;
  if (field.option != nullptr) {
    next.depth.match[field.slot] = Text<kMatchBytes + 1>("x");
  } else if (field.set_text != nullptr) {
    field.set_text("/dev/x", next);
  } else {
    const int now = field.number(next);
    field.set_number(now == field.high ? field.low : field.high, next);
  }
  EXPECT_FALSE(equal(field, {}, next)) << field.name;
  return next;
}

TEST(Permission, WhatChangesNothingIsEverybodys) {
  for (const Access access : {Access::kRead, Access::kHarmless, Access::kTune, Access::kAdmin}) {
    EXPECT_EQ(refusal({}, {}, access), "");
  }
}

TEST(Permission, EachFieldAloneTakesItsAccessAndNoLess) {
  std::array<int, 4> counts{};
  for (std::size_t place = 0; place < field_count(); ++place) {
    const Field known = field(place);
    Settings active;
    active.limits = {
        .least_range_mm = 500, .most_period_ms = 60'000, .streams = StreamLimit::kNone};
    Settings next = with_other(known);
    if (known.group != "limits") {
      next.limits = active.limits;
    } else {
      active.limits = {};
    }
    ++counts[static_cast<std::size_t>(known.access)];
    EXPECT_NE(known.access, Access::kRead);
    for (const Access access : {Access::kRead, Access::kHarmless, Access::kTune, Access::kAdmin}) {
      const std::string said = refusal(active, next, access);
      EXPECT_EQ(said.empty(), access >= known.access) << known.group << "." << known.name << said;
    }
  }
  EXPECT_GT(counts[static_cast<std::size_t>(Access::kTune)], 15);
}

// docs/SECURITY.md names each of them.
TEST(Permission, TheHarmlessListIsTheDocuments) {
  std::string all;
  for (std::size_t place = 0; place < field_count(); ++place) {
    const Field known = field(place);
    if (known.access == Access::kHarmless) {
      all += std::string(known.group) + "." + std::string(known.name) + " ";
    }
  }
  EXPECT_EQ(all,
            "depth.max_range_mm streams.depth streams.width streams.source streams.disparity "
            "streams.pmd_raw streams.grey_left streams.grey_right streams.cloud streams.cloud_step "
            "streams.parity ");
}

// The serial line and the search have no condition that would tell it.
TEST(Permission, WhatBlindsWithoutAWordIsTheAdmins) {
  for (const char* const json :
       {R"({"sectors": {"least_mm": 10000}})", R"({"sectors": {"pixels": 1000}})",
        R"({"sectors": {"above_mm": 0}})", R"({"sectors": {"below_mm": 0}})",
        R"({"depth": {"disparities": 8}})", R"({"depth": {"match": {"min-disparity": 1000}}})"}) {
    EXPECT_NE(refusal({}, changed(json), Access::kTune), "") << json;
    EXPECT_EQ(refusal({}, changed(json), Access::kAdmin), "") << json;
  }
}

TEST(Permission, SaysWhichFieldAndWhatItTakes) {
  EXPECT_EQ(refusal({}, changed(R"({"udp": {"port": 68}})"), Access::kHarmless),
            "udp.port: takes a key with role admin: pair with the sensor (stof pair), or use its "
            "cable");
  EXPECT_EQ(refusal({}, changed(R"({"udp": {"port": 68}})"), Access::kTune),
            "udp.port: takes a key with role admin");
  EXPECT_EQ(refusal({}, changed(R"({"name": "x"})"), Access::kHarmless),
            "name: takes a key with role tune or admin: pair with the sensor (stof pair), or use "
            "its cable");
}

TEST(Permission, NobodyButTheAdminLeavesTheLimits) {
  const std::array<std::pair<const char*, const char*>, 6> beyond{{
      {R"({"depth": {"max_range_mm": 999}})", "depth.max_range_mm: limits.least_range_mm is 1000"},
      {R"({"period_ms": 1001})",
       "period_ms: limits.least_period_ms is 0, limits.most_period_ms is 1000"},
      {R"({"streams": {"depth": "off"}})",
       "streams: limits.streams is keep: depth, width, source and cloud are not switched off"},
      {R"({"streams": {"width": "off"}})",
       "streams: limits.streams is keep: depth, width, source and cloud are not switched off"},
      {R"({"streams": {"source": "off"}})",
       "streams: limits.streams is keep: depth, width, source and cloud are not switched off"},
      {R"({"streams": {"depth": "off", "cloud": "on"}})",
       "streams: limits.streams is keep: depth, width, source and cloud are not switched off"},
  }};
  for (const auto& [json, said] : beyond) {
    EXPECT_EQ(refusal({}, changed(json), Access::kTune), said);
    EXPECT_EQ(refusal({}, changed(json), Access::kAdmin), "");
  }
  for (const char* const json :
       {R"({"depth": {"max_range_mm": 1000}})", R"({"period_ms": 1000})",
        R"({"streams": {"depth": "raw", "grey_left": "rvl", "cloud": "on"}})"}) {
    EXPECT_EQ(refusal({}, changed(json), Access::kTune), "");
  }
}

TEST(Permission, ALimitIsOfWhatIsActiveAndOfWhatChanges) {
  const Settings strict = changed(
      R"({"depth": {"max_range_mm": 600}, "limits": {"streams": "fixed", "least_period_ms": 50}})");
  // What the admin has set beyond the limits stays where it is.
  EXPECT_EQ(refusal(strict, changed(R"({"period_ms": 60})", strict), Access::kTune), "");
  EXPECT_EQ(refusal(strict, changed(R"({"streams": {"grey_left": "rvl"}})", strict), Access::kTune),
            "streams: limits.streams is fixed");
  EXPECT_EQ(refusal(strict, changed(R"({"period_ms": 40})", strict), Access::kTune),
            "period_ms: limits.least_period_ms is 50, limits.most_period_ms is 1000");
  const Settings free = changed(R"({"limits": {"streams": "none"}})");
  EXPECT_EQ(refusal(free, changed(R"({"streams": {"depth": "off"}})", free), Access::kHarmless),
            "");
  // A stream that may not be switched off and was off may stay so.
  const Settings off = changed(R"({"streams": {"width": "off"}})");
  EXPECT_EQ(refusal(off, changed(R"({"streams": {"depth": "raw"}})", off), Access::kHarmless), "");
}

}  // namespace
}  // namespace stof::settings

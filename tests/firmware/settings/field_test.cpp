#include "firmware/settings/fields/field.h"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/match_options.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/field_value.h"
#include "firmware/settings/fields/schema.h"
#include "firmware/wire/crc32c.h"

namespace stof::settings {
namespace {

std::string path_of(const Field& field) {
  return std::string(field.group) + (field.group.empty() ? "" : ".") + std::string(field.name);
}

std::string json_of(const Field& field, const Settings& settings) {
  std::array<char, 128> space;
  PagedWriter out(space);
  write_value(field, settings, out);
  return std::string(out.text());
}

std::string document_of(const Settings& settings) {
  std::array<char, kMostDocumentBytes> space;
  PagedWriter out(space);
  write_document(settings, out);
  EXPECT_TRUE(out.complete()) << out.total();
  return std::string(out.text());
}

// The path's groups as objects about it.
std::string nest(const std::string& path, const std::string& value) {
  const std::size_t dot = path.find('.');
  return dot == std::string::npos
             ? "{\"" + path + "\": " + value + "}"
             : "{\"" + path.substr(0, dot) + "\": " + nest(path.substr(dot + 1), value) + "}";
}

std::string refusal(const std::string& json) {
  Settings settings;
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  if (parse(json, settings, why)) {
    return "accepted";
  }
  EXPECT_EQ(settings, Settings{});
  return std::string(why.text());
}

// What is said about PATH=VALUE; empty: it was taken.
std::string told(std::string_view path, std::string_view value, Settings& settings) {
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  return parse_field(path, value, settings, why) ? "" : std::string(why.text());
}

// Values that a field takes, as JSON, none of them its default.
std::vector<std::string> samples(const Field& field) {
  const std::vector<std::string> texts{
      "4",         "\"parabola\"",     "\"9x7\"", "\"64x1\"", "0",       "1",      "2",
      "-3",        "16777216",         "true",    "false",    "\"off\"", "\"on\"", "\"3,7\"",
      "\"36,36\"", "\"least-squares\""};
  std::vector<std::string> taken;
  switch (field.kind) {
    case Kind::kInteger:
      return {std::to_string(field.low), std::to_string(field.high)};
    case Kind::kBoolean:
      return {"true", "false"};
    case Kind::kChoice:
      for (const std::string_view value : field.values) {
        taken.push_back("\"" + std::string(value) + "\"");
      }
      return taken;
    case Kind::kText:
      return {"\"a\"", "\"" + std::string(static_cast<std::size_t>(field.high), 'x') + "\"",
              "\"K\u00fcche 2\""};
    case Kind::kDevice:
      return {"\"\"", "\"/dev/ttyAMA0\"", "\"/dev/" + std::string(kDeviceBytes - 5, 'x') + "\""};
    case Kind::kInterface:
      return {"\"192.168.7.2/24\"", "\"223.255.255.1/30\"", "\"\""};
    case Kind::kIpv4:
      return {"\"192.168.7.1\"", "\"255.255.255.255\"", "\"\""};
    case Kind::kHostname:
      return {"\"a\"", "\"front-7\"", "\"" + std::string(kHostnameBytes, 'x') + "\""};
    case Kind::kMatch:
      for (const std::string& text : texts) {
        if (Settings unused;
            assign(field,
                   {.written = text[0] == '"' ? Written::kString : Written::kNumber,
                    .text = text[0] == '"' ? std::string_view(text).substr(1, text.size() - 2)
                                           : std::string_view(text)},
                   unused)) {
          taken.push_back(text);
        }
      }
      return taken;
  }
  return taken;
}

TEST(Fields, HavePathsThatLeadBackToThem) {
  ASSERT_LE(field_count(), kMostFields);
  ASSERT_LE(dsp::match_options().size(), kMatchSlots);
  for (std::size_t place = 0; place < field_count(); ++place) {
    EXPECT_EQ(find_field(path_of(field(place))), place) << path_of(field(place));
    EXPECT_FALSE(is_group(path_of(field(place))));
    EXPECT_TRUE(field(place).group.empty() || is_group(field(place).group));
    EXPECT_FALSE(field(place).meaning.empty());
  }
  for (const char* const none : {"", ".", ".name", "name.", "depth", "depth.match", "streams.", "x",
                                 "depth.match.fill", "depth..preset"}) {
    EXPECT_EQ(find_field(none), field_count()) << none;
  }
}

TEST(Fields, ComeThroughJsonCommandLineAndDocument) {
  for (std::size_t place = 0; place < field_count(); ++place) {
    const Field known = field(place);
    const std::string path = path_of(known);
    ASSERT_GE(samples(known).size(), 2U) << path;
    for (const std::string& sample : samples(known)) {
      Settings by_json;
      std::array<char, kWhyBytes> space;
      PagedWriter why(space);
      FieldSet named;
      ASSERT_TRUE(parse(nest(path, sample), by_json, why, &named)) << why.text();
      EXPECT_EQ(named, FieldSet{}.set(place)) << path;
      const std::string written = json_of(known, by_json);
      if (sample == "true" || sample == "false") {
        EXPECT_TRUE(written == sample || written == "\"on\"" || written == "\"off\"") << path;
      } else {
        EXPECT_EQ(written, sample) << path;
      }

      Settings by_document;
      ASSERT_TRUE(parse(document_of(by_json), by_document, why)) << why.text();
      EXPECT_EQ(by_document, by_json) << path;

      const std::string bare = sample[0] == '"' ? sample.substr(1, sample.size() - 2) : sample;
      Settings by_line;
      ASSERT_EQ(told(path, bare, by_line), "");
      EXPECT_EQ(by_line, by_json) << path;

      Settings copied;
      copy_field(known, by_json, copied);
      EXPECT_EQ(copied, by_json) << path;
      EXPECT_TRUE(equal(known, copied, by_json));
    }
  }
}

TEST(Fields, AreAllDifferentMembers) {
  Settings settings;
  for (std::size_t place = 0; place < field_count(); ++place) {
    const Settings before = settings;
    for (const std::string& sample : samples(field(place))) {
      Settings next = before;
      ASSERT_EQ(refusal(nest(path_of(field(place)), sample)), "accepted");
      std::array<char, kWhyBytes> space;
      PagedWriter why(space);
      ASSERT_TRUE(parse(nest(path_of(field(place)), sample), next, why));
      if (!equal(field(place), before, next)) {
        settings = next;
        break;
      }
    }
    EXPECT_FALSE(equal(field(place), before, settings)) << path_of(field(place));
    for (std::size_t other = 0; other < field_count(); ++other) {
      EXPECT_TRUE(other == place || equal(field(other), before, settings))
          << path_of(field(place)) << " changes " << path_of(field(other));
    }
  }
}

TEST(Fields, RefuseWhatIsNoneOfTheirValues) {
  for (std::size_t place = 0; place < field_count(); ++place) {
    const Field known = field(place);
    const std::string path = path_of(known);
    std::vector<std::string> wrong{"null",        "[]",  "{}",  "[1]",         "{\"a\": 1}",
                                   "\"\\u0041\"", "1.5", "1e3", "99999999999", "-99999999999"};
    if (known.kind != Kind::kMatch) {
      if (known.kind != Kind::kText && known.kind != Kind::kHostname) {
        wrong.emplace_back("\"foo\"");
      }
      if (known.kind != Kind::kBoolean) {
        wrong.emplace_back("true");
      }
      if (known.kind != Kind::kInteger) {
        wrong.emplace_back("1");
      }
    }
    if (known.kind == Kind::kInteger) {
      wrong.push_back(std::to_string(known.low - 1));
      wrong.push_back(std::to_string(known.high + 1));
    }
    for (const std::string& value : wrong) {
      const std::string why = refusal(nest(path, value));
      EXPECT_TRUE(why.starts_with(path + ": takes ")) << path << " = " << value << ": " << why;
    }
  }
}

// What would end a line, or turn the writing around it, on somebody's screen.
TEST(Fields, NamesHoldNothingThatMovesTheTextAroundThem) {
  for (const std::string character :
       {"\xC2\x80", "\xC2\x9B", "\xC2\x9F", "\xD8\x9C", "\xE2\x80\x8E", "\xE2\x80\x8F",
        "\xE2\x80\xA8", "\xE2\x80\xA9", "\xE2\x80\xAA", "\xE2\x80\xAE", "\xE2\x81\xA6",
        "\xE2\x81\xA9"}) {
    EXPECT_NE(refusal(nest("name", "\"a" + character + "b\"")), "accepted");
  }
  for (const std::string character : {"\xC2\xA0", "\xC3\xA4", "\xD8\x9B", "\xE2\x80\x90",
                                      "\xE2\x82\xAC", "\xE2\x81\xAA", "\xF0\x9F\x98\x80"}) {
    EXPECT_EQ(refusal(nest("name", "\"a" + character + "b\"")), "accepted");
  }
}

TEST(Fields, SayWhatTheyTake) {
  EXPECT_EQ(refusal(R"({"streams": {"depth": "foo"}})"),
            "streams.depth: takes off, raw, rvl or fit, not \"foo\"");
  EXPECT_EQ(refusal(R"({"serial": {"baud": 100}})"),
            "serial.baud: takes 57600 to 12000000, not 100");
  EXPECT_EQ(refusal(R"({"depth": {"guided": "yes"}})"),
            "depth.guided: takes true or false, not \"yes\"");
  EXPECT_EQ(refusal(R"({"depth": {"match": {"lr": 300}}})"),
            "depth.match.lr: takes 0..256 or off, or preset, not 300");
  EXPECT_EQ(refusal(R"({"serial": {"device": "/etc/passwd"}})"),
            "serial.device: takes a name below /dev/ of at most 63 bytes, or nothing, not "
            "\"/etc/passwd\"");
  EXPECT_EQ(refusal(R"({"depth": {"match": {"fill": true}}})"),
            "depth.match.fill: what is made up is not published: leave it out");
  EXPECT_EQ(refusal(R"({"depth": 5})"), "depth: takes an object of settings");
  EXPECT_EQ(refusal(R"({"name": {}})"),
            "name: takes 1 to 31 bytes of text without quotes and backslashes, not an object");
  EXPECT_EQ(refusal(R"({"colour": 5})"), "\"colour\": there is no such setting");
  EXPECT_EQ(refusal(R"({"depth": {"colour": {"x": 5}}})"),
            "\"depth.colour\": there is no such setting");
  Settings settings;
  EXPECT_EQ(told("streams.depth", "foo", settings),
            "streams.depth: takes off, raw, rvl or fit, not \"foo\"");
  EXPECT_EQ(settings, Settings{});
}

TEST(Fields, ThreadsAreAsManyAsTheBoardHasUnlessTheyAreGiven) {
  EXPECT_EQ(Settings{}.compute.threads, 0);
  const Field threads = field(find_field("compute.threads"));
  EXPECT_EQ(threads.applies, Applies::kRestart);
  for (int count = 0; count <= kMostThreads; ++count) {
    Settings settings;
    EXPECT_EQ(told("compute.threads", std::to_string(count), settings), "");
    EXPECT_EQ(settings.compute.threads, count);
    EXPECT_EQ(json_of(threads, settings), std::to_string(count));
  }
  EXPECT_EQ(refusal(R"({"compute": {"threads": 9}})"), "compute.threads: takes 0 to 8, not 9");
  EXPECT_EQ(refusal(R"({"compute": {"threads": -1}})"), "compute.threads: takes 0 to 8, not -1");
  EXPECT_EQ(refusal(R"({"compute": {"threads": "all"}})"),
            "compute.threads: takes 0 to 8, not \"all\"");
  EXPECT_EQ(refusal(R"({"compute": {"cores": 1}})"), "\"compute.cores\": there is no such setting");
}

TEST(Fields, DeviceStaysBelowDev) {
  for (const char* const name : {"/dev/", "/dev/../etc/passwd", "dev/tty", "/devil", "tty"}) {
    EXPECT_NE(refusal("{\"serial\": {\"device\": \"" + std::string(name) + "\"}}"), "accepted");
  }
}

TEST(Fields, MatchNumbersAreWrittenOneWay) {
  Settings settings;
  EXPECT_EQ(told("depth.match.lr", "007", settings), "");
  EXPECT_EQ(json_of(field(find_field("depth.match.lr")), settings), "7");
  EXPECT_EQ(told("depth.match.lr", "preset", settings), "");
  EXPECT_EQ(settings, Settings{});
}

// What every frame says of its settings is the check sum of what `get` reads.
TEST(Documents, HaveTheFingerprintOfTheirText) {
  Settings settings;
  const auto crc = [&] {
    const std::string text = document_of(settings);
    return wire::crc32c(std::as_bytes(std::span(text)));
  };
  EXPECT_EQ(fingerprint(settings), crc());
  const std::uint32_t before = fingerprint(settings);
  settings.depth.max_range_mm = 500;
  EXPECT_EQ(fingerprint(settings), crc());
  EXPECT_NE(fingerprint(settings), before);
}

TEST(Documents, OfTheLargestValuesFit) {
  Settings settings;
  for (std::size_t place = 0; place < field_count(); ++place) {
    std::size_t longest = 0;
    for (const std::string& sample : samples(field(place))) {
      Settings next = settings;
      std::array<char, kWhyBytes> space;
      PagedWriter why(space);
      ASSERT_TRUE(parse(nest(path_of(field(place)), sample), next, why));
      if (json_of(field(place), next).size() > longest) {
        longest = json_of(field(place), next).size();
        settings = next;
      }
    }
  }
  EXPECT_LT(document_of(settings).size() + 256, kMostDocumentBytes);
  EXPECT_LT(settings_schema().size(), 65536U);
}

}  // namespace
}  // namespace stof::settings

#include "host/viewer/page_message.h"

#include <string>

#include <gtest/gtest.h>

namespace stof::viewer {
namespace {

// The wish of a request with these members; fails where there is none.
template <typename Kind>
Kind wish(const std::string& members) {
  const auto said = parse_page_message(R"({"id":1,"ticket":"t",)" + members + "}");
  EXPECT_TRUE(said) << members;
  if (!said) {
    return {};
  }
  const Request& request = std::get<Request>(*said);
  EXPECT_EQ(request.id, 1U);
  EXPECT_EQ(request.ticket, "t");
  return std::get<Kind>(request.wish);
}

TEST(PageMessage, ReadsEachWish) {
  wish<ReadSettings>(R"("do":"settings")");
  wish<SaveSettings>(R"("do":"save")");
  EXPECT_EQ(
      wish<ChangeSettings>(R"("do":"set","settings":{"a.b-c":"x y","b":-3,"c":true,"d":"12"})")
          .assignments,
      (std::vector<std::string>{"a.b-c=\"x y\"", "b=-3", "c=true", "d=\"12\""}));
  EXPECT_EQ(wish<GiveFault>(R"("do":"faults")").order, "list");
  EXPECT_EQ(wish<GiveFault>(R"("do":"fault","device":"pmd","kind":"dark","edges":0)").order,
            "pmd:dark");
  EXPECT_EQ(wish<GiveFault>(R"("do":"fault","device":"pmd","kind":"dark","edges":30)").order,
            "pmd:dark:30");
  EXPECT_TRUE(wish<SetRecording>(R"("do":"record","on":true)").on);
  EXPECT_FALSE(wish<SetPlaying>(R"("do":"play","on":false)").on);
  EXPECT_EQ(wish<SeekTo>(R"("do":"seek","to_ms":1500)").ms, 1500U);
  EXPECT_EQ(wish<BeginPairing>(R"("do":"pair","code":"","role":"tune")").role, "tune");
  EXPECT_EQ(wish<BeginPairing>(R"("do":"pair","code":"00aF-11","role":"admin")").code, "00aF-11");
  EXPECT_EQ(wish<GiveDigits>(R"("do":"digits","digits":"123 456")").digits, "123 456");
  wish<EndPairing>(R"("do":"end_pairing")");
  wish<ReadRelease>(R"("do":"release")");
  EXPECT_EQ(wish<PutRelease>(R"("do":"update","file":"rpi4 2.0.update")").file, "rpi4 2.0.update");
}

TEST(PageMessage, ReadsWhatItLooksAt) {
  const auto said = parse_page_message(R"({"show":["depth","left"],"frames":2,"quiet":true})");
  ASSERT_TRUE(said);
  const Look& look = std::get<Look>(*said);
  EXPECT_EQ(look.planes, kDepth | kLeft);
  EXPECT_EQ(look.frames, 2);
  EXPECT_TRUE(look.quiet);
}

TEST(PageMessage, RefusesWhatIsNotAsWritten) {
  const std::string long_name(65, 'a');
  const std::string long_text(257, 'a');
  std::string many = R"("do":"set","settings":{)";
  for (int i = 0; i < 65; ++i) {
    many += (i == 0 ? "\"a" : ",\"a") + std::to_string(i) + "\":1";
  }
  for (const std::string& members :
       {std::string(R"("do":"format")"),
        std::string(R"("do":1)"),
        std::string(R"("do":null)"),
        std::string(R"("do":"settings","more":1)"),
        std::string(R"("do":"set")"),
        std::string(R"("do":"set","settings":{})"),
        std::string(R"("do":"set","settings":[])"),
        std::string(R"("do":"set","settings":{"a":1.5})"),
        std::string(R"("do":"set","settings":{"a":null})"),
        std::string(R"("do":"set","settings":{"a":{"b":1}})"),
        std::string(R"("do":"set","settings":{"a=b":1})"),
        std::string(R"("do":"set","settings":{"/etc/passwd":1})"),
        std::string(R"("do":"set","settings":{"":1})"),
        std::string(R"("do":"pair","code":"","role":"owner")"),
        std::string(R"("do":"pair","code":"moon","role":"admin")"),
        std::string(R"("do":"pair","code":1,"role":"admin")"),
        std::string(R"("do":"pair","code":"")"),
        R"("do":"pair","role":"admin","code":")" + std::string(65, '0') + '"',
        std::string(R"("do":"digits","digits":"12345a")"),
        std::string(R"("do":"digits","digits":"12345678901234567")"),
        std::string(R"("do":"end_pairing","id2":1)"),
        std::string(R"("do":"update","file":"../a.update")"),
        std::string(R"("do":"update","file":"/a.update")"),
        std::string(R"("do":"update","file":".update")"),
        std::string(R"("do":"update","file":"a\u0000b")"),
        std::string(R"("do":"update","file":"")"),
        R"("do":"update","file":")" + std::string(256, 'a') + '"',
        R"("do":"set","settings":{")" + long_name + R"(":1})",
        R"("do":"set","settings":{"a":")" + long_text + "\"}",
        many + "}",
        std::string(R"("do":"fault","device":"pmd","kind":"dark")"),
        std::string(R"("do":"fault","device":"pmd:x","kind":"dark","edges":0)"),
        std::string(R"("do":"fault","device":"pmd","kind":"dark\n","edges":0)"),
        std::string(R"("do":"fault","device":"pmd","kind":"dark","edges":-1)"),
        std::string(R"("do":"fault","device":"pmd","kind":"dark","edges":1000001)"),
        std::string(R"("do":"record","on":1)"),
        std::string(R"("do":"record")"),
        std::string(R"("do":"seek","to_ms":-1)"),
        std::string(R"("do":"seek","to_ms":1.0)"),
        std::string(R"("do":"seek","to_ms":99999999999999)"),
        std::string(R"("do":"record","on":true,"show":["depth"],"frames":1,"quiet":false)")}) {
    EXPECT_FALSE(parse_page_message(R"({"id":1,"ticket":"t",)" + members + "}")) << members;
  }
  for (const char* const text :
       {R"({"do":"save"})", R"({"do":"save","id":1})", R"({"do":"save","id":-1,"ticket":"t"})",
        R"({"do":"save","id":4294967296,"ticket":"t"})", R"({"do":"save","id":1,"ticket":5})",
        R"({"do":"save","id":"1","ticket":"t"})", "\xff", "\"do\"",
        R"({"do":"set","id":1,"ticket":"t","settings":{"a":")"
        "\xff"
        R"("}})"}) {
    EXPECT_FALSE(parse_page_message(text)) << text;
  }
}

TEST(PageMessage, RefusesWhatNamesAMemberTwice) {
  for (const char* const members :
       {R"("do":"settings","do":"save")", R"("do":"save","id":1)", R"("ticket":"t","do":"save")",
        R"("do":"set","settings":{"a":1,"b":2,"a":1})",
        R"("do":"set","settings":{"a":1},"settings":{"a":1})",
        R"("do":"set","settings":{"a":1,"\u0061":2})"}) {
    EXPECT_FALSE(parse_page_message(R"({"id":1,"ticket":"t",)" + std::string(members) + "}"))
        << members;
  }
  EXPECT_FALSE(parse_page_message(R"({"show":["depth"],"frames":1,"frames":2,"quiet":false})"));
  // The same name in two objects is none twice.
  EXPECT_TRUE(parse_page_message(R"({"id":1,"ticket":"t","do":"set","settings":{"id":1}})"));
}

}  // namespace
}  // namespace stof::viewer

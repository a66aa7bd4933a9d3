#include "host/cli/words.h"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/cli/completion.h"
#include "host/cli/failure.h"

namespace stof::host {
namespace {

const std::vector<std::string> kKnown{"view", "record", "replay", "recover", "info"};

TEST(NearestWord, IsTheOneThatWasMistyped) {
  EXPECT_EQ(nearest_word("veiw", kKnown), "view");     // exchanged
  EXPECT_EQ(nearest_word("recrd", kKnown), "record");  // missing
  EXPECT_EQ(nearest_word("infoo", kKnown), "info");    // too many
  EXPECT_EQ(nearest_word("rebover", kKnown), "recover");
}

TEST(NearestWord, IsNoneWhereNothingIsNear) {
  EXPECT_EQ(nearest_word("nonsense", kKnown), "");
  EXPECT_EQ(nearest_word("", kKnown), "");
  EXPECT_EQ(nearest_word("x", {}), "");
  EXPECT_EQ(nearest_word(std::string(100'000, 'v'), kKnown), "");
}

// A tool with a command, a group of one, and one that takes whatever it is given.
struct SmallTool {
  CLI::App app{"", "tool"};
  std::string kind;
  bool on = false;

  SmallTool() {
    app.require_subcommand(1);
    CLI::App& view = *app.add_subcommand("view", "");
    view.add_option("SENSOR", kind, "");
    view.add_flag("--json", on, "");
    view.add_option("--to", kind, "");
    CLI::App& calib = *app.add_subcommand("calib", "");
    calib.require_subcommand(1);
    CLI::App& rig = *calib.add_subcommand("rig", "");
    rig.add_option("--as", kind, "")->check(CLI::IsMember({"ros", "opencv"}));
    app.add_subcommand("any", "")->allow_extras();
  }

  // What the words are refused with; empty: they are not.
  std::string judged(std::vector<std::string> words) const {
    std::vector<char*> raw;
    for (std::string& word : words) {
      raw.push_back(word.data());
    }
    try {
      judge_words(app, raw);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.code(), Exit::kBadInput);
      return failure.what();
    }
    return {};
  }
};

TEST(JudgedWords, AreRefusedWhereNoSuchCommandOrFlagIs) {
  const SmallTool tool;
  EXPECT_EQ(tool.judged({"veiw", "--help"}),
            "\"veiw\": tool has no such command, did you mean view: try tool --help");
  EXPECT_EQ(tool.judged({"--help", "nonsense"}),
            "\"nonsense\": tool has no such command: try tool --help");
  EXPECT_EQ(tool.judged({"calib", "rgi"}),
            "\"rgi\": tool calib has no such command, did you mean rig: try tool calib --help");
  EXPECT_EQ(tool.judged({"view", "--jsno", "--help"}),
            "--jsno: tool view has no such flag, did you mean --json: try tool view --help");
  EXPECT_EQ(tool.judged({"calib", "rig", "--ass=ros"}),
            "--ass: tool calib rig has no such flag, did you mean --as: try tool calib rig --help");
}

TEST(JudgedWords, ArePassedOnWhereTheyMayMeanSomething) {
  const SmallTool tool;
  EXPECT_EQ(tool.judged({}), "");
  EXPECT_EQ(tool.judged({"--help"}), "");
  EXPECT_EQ(tool.judged({"view", "veiw", "--json", "--to=calib", "-x", "-5"}), "");
  EXPECT_EQ(tool.judged({"view", "--", "--nonsense"}), "");
  EXPECT_EQ(tool.judged({"any", "--nonsense"}), "");
}

TEST(BashCompletion, HasEveryCommandFlagAndValueOfTheTree) {
  const SmallTool tool;
  const std::string script = bash_completion(tool.app);
  for (const char* const part :
       {"\"tool view\" | \"tool calib\" | \"tool calib rig\" | \"tool any\"",
        "\"tool\") words=\"view calib any --help\"", "\"tool view\") words=\"--help --json --to\"",
        "\"tool calib rig --as\") words=\"ros opencv\"", "\"tool view --to\") return",
        "complete -o default -F _tool tool"}) {
    EXPECT_NE(script.find(part), std::string::npos) << part << "\n" << script;
  }
}

}  // namespace
}  // namespace stof::host

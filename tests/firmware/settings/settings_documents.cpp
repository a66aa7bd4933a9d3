#include <array>
#include <cstdio>
#include <iostream>
#include <string>
#include <string_view>

#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/schema.h"

// settings_documents schema|tables|defaults: prints that.
// settings_documents judge: for each line of its input, a document: "ok", or what is wrong.
namespace {

using namespace stof::settings;

std::string judge(const std::string& line) {
  Settings settings;
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  return parse(line, settings, why) ? "ok" : std::string(why.text());
}

std::string defaults() {
  std::array<char, kMostDocumentBytes> space;
  PagedWriter out(space);
  write_document({}, out);
  return std::string(out.text());
}

int run(std::string_view what) {
  std::string text;
  if (what == "schema") {
    text = settings_schema();
  } else if (what == "tables") {
    text = settings_tables();
  } else if (what == "defaults") {
    text = defaults();
  } else if (what == "judge") {
    for (std::string line; std::getline(std::cin, line);) {
      text += judge(line) + "\n";
    }
  } else {
    return 2;
  }
  std::fwrite(text.data(), 1, text.size(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return run(argc == 2 ? argv[1] : ""); }

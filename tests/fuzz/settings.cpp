#include <array>
#include <string>

#include "firmware/settings/fields/document.h"
#include "tests/fuzz/fuzz_input.h"

// A document of settings, any bytes: taken whole, or refused with nothing changed.
void stof::fuzz::run(std::span<const std::byte> input) {
  const auto* const begin = reinterpret_cast<const char*>(input.data());
  const std::string text(begin, begin + input.size());
  std::array<char, settings::kWhyBytes> space;
  settings::PagedWriter why(space);
  settings::Settings parsed;
  if (!settings::parse(text, parsed, why)) {
    fuzz::require(parsed == settings::Settings{});
    fuzz::require(!why.text().empty() && why.text().find('\n') == std::string_view::npos);
    return;
  }
  std::array<char, settings::kMostDocumentBytes> document;
  settings::PagedWriter out(document);
  settings::write_document(parsed, out);
  fuzz::require(out.complete());
  settings::Settings again;
  fuzz::require(settings::parse(out.text(), again, why));
  fuzz::require(again == parsed);
}

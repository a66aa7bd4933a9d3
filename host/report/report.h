#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <vector>

#include "dataset/dataset.h"

// The book chapter's experiments, repeated with the appliance's own matcher on recorded scenes, as
// one self-contained HTML page: no scripts, no network, pictures inside.
namespace stof::host {

struct ReportOptions {
  std::vector<std::filesystem::path> scenes;  // at least one, unless `corridor` is given
  std::filesystem::path corridor;             // a scene with a rig in meta.txt; empty: none
  std::filesystem::path out;                  // the HTML file
  int runs = 7;                               // of which the median time is shown
  bool plain = false;                         // times of whole methods with reference kernels too
  bool quick = false;                         // small 2.5D views
  std::function<void(const char*)> begins;    // called with each part's name; may be empty
};

struct ReportResult {
  std::string summary;            // the verdicts and a few figures, as lines of text
  std::set<std::string> refused;  // experiments that this matcher cannot run
};

// Writes the page. One line when a scene cannot be read or the file cannot be written.
dataset::Loaded<ReportResult> write_report(const ReportOptions& options);

}  // namespace stof::host

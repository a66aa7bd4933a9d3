#include "host/report/report.h"

#include <array>
#include <fstream>

#include "dataset/files/file.h"
#include "host/report/stereo/sections.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// The processor's name as this machine tells it.
std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
#if defined(__aarch64__)
  return "a 64-bit ARM processor";
#else
  return "an unnamed processor";
#endif
}

std::vector<std::string> lead(const Study& study) {
  std::string names;
  for (const Subject& subject : study.subjects()) {
    add_to(names, subject.name());
  }
  return {
      "The stereo methods of the 2006 book chapter on fusing stereo and PMD depth for mobile "
      "robots (Kuhnert & Stommel), repeated with the matcher of the stof appliance, which "
      "computes in integers. Each claim of the chapter stands beside what was measured here and "
      "whether it holds.",
      "Scenes: " + names + ". Measured on one thread of " + processor() +
          ". Other programs may have run beside it: compare times of one table only."};
}

dataset::Loaded<Study> load(const ReportOptions& options) {
  std::vector<Subject> subjects;
  for (const std::filesystem::path& dir : options.scenes) {
    dataset::Loaded<dataset::StereoScene> scene = dataset::read_stereo_scene(dir);
    if (!scene) {
      return std::unexpected(std::move(scene.error()));
    }
    subjects.emplace_back(std::move(*scene));
  }
  std::optional<Subject> corridor;
  if (!options.corridor.empty()) {
    dataset::Loaded<dataset::StereoScene> scene = dataset::read_stereo_scene(options.corridor);
    if (!scene) {
      return std::unexpected(std::move(scene.error()));
    }
    if (!scene->rig) {
      return dataset::refuse((options.corridor / "meta.txt").string() +
                             R"(: has no rig: add lines such as "f_px 615" and "baseline_m 0.12")");
    }
    corridor.emplace(std::move(*scene));
  }
  return Study(std::move(subjects), std::move(corridor), options.runs, options.quick,
               options.plain);
}

}  // namespace

dataset::Loaded<ReportResult> write_report(const ReportOptions& options) {
  dataset::Loaded<Study> study = load(options);
  if (!study) {
    return std::unexpected(std::move(study.error()));
  }
  Page page;
  struct Part {
    const char* name;
    void (*add)(Study&, Page&);
  };
  const std::array parts{
      Part{"scenes", add_scenes},
      Part{"methods", add_methods},
      Part{"maps", add_maps},
      Part{"time by block", add_block_time},
      Part{"block sizes", add_block_sizes},
      Part{"adaptive blocks", add_adaptive},
      Part{"interest", add_interest},
      Part{"filters", add_filters},
      Part{"pyramid", add_pyramid},
      Part{"annealing", add_annealing},
      Part{"presets", add_presets},
      Part{"brightness", add_brightness},
      Part{"corridor", add_corridor},
  };
  for (const Part& part : parts) {
    if (options.begins) {
      options.begins(part.name);
    }
    part.add(*study, page);
  }
  const std::string html = page.html("The chapter's stereo, measured", lead(*study));
  if (std::expected<void, dataset::Problem> written = write_page(options.out, html); !written) {
    return std::unexpected(std::move(written.error()));
  }
  return ReportResult{.summary = study->notes() + "\n" + page.verdicts(),
                      .refused = study->refused()};
}

}  // namespace stof::host

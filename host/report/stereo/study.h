#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/stereo/match_params.h"
#include "host/evaluate/stereo/disparity_score.h"
#include "host/picture/disparity_picture.h"
#include "host/report/page/page.h"
#include "lab/match_params.h"
#include "lab/search/annealing.h"

// The common part of the report's sections: scenes, and one way to run a method on them.
namespace stof::host {

// A scene, and how all of its maps are drawn.
struct Subject {
  dataset::StereoScene scene;
  DisparityScale scale;  // the range of the truth; without truth the search range

  explicit Subject(dataset::StereoScene loaded);
  const std::string& name() const { return scene.name; }
};

// A way to match, by the parameters of the appliance's own matcher.
struct Experiment {
  std::string name;
  lab::MatchParams params;
  // Simulated annealing, which begins with the map of params.
  std::optional<lab::Acceptance> annealing = std::nullopt;
};

struct Outcome {
  dataset::Image<float> disparity;  // px, +inf = none
  double filled = 0;                // share of its disparities that were made up, not matched
  double ms = 0;                    // median, one thread, this machine
  DisparityScore score;
};

class Study {
 public:
  // quick: small runs and no drawings of what takes long, for tests.
  Study(std::vector<Subject> subjects, std::optional<Subject> corridor, int runs, bool quick,
        bool plain = false)
      : subjects_(std::move(subjects)),
        corridor_(std::move(corridor)),
        runs_(runs),
        quick_(quick),
        plain_(plain) {}

  const std::vector<Subject>& subjects() const { return subjects_; }
  const std::optional<Subject>& corridor() const { return corridor_; }
  int runs() const { return runs_; }
  bool quick() const { return quick_; }
  // Whether whole methods are also timed with the reference kernels.
  bool plain() const { return plain_; }

  // The map and its score. None where the matcher refuses the parameters for this scene: noted.
  std::optional<Outcome> run(const dataset::StereoScene& scene, const Experiment& experiment);
  // The preset as an experiment.
  std::optional<Outcome> run_preset(const dataset::StereoScene& scene, std::string_view name,
                                    bool fill = false);
  // A line of the text that goes with the page.
  void note(const std::string& scene, const std::string& method, const Outcome& outcome);
  const std::string& notes() const { return notes_; }
  // Names of the experiments that could not be run.
  const std::set<std::string>& refused() const { return refused_; }

 private:
  std::vector<Subject> subjects_;
  std::optional<Subject> corridor_;
  int runs_;
  bool quick_;
  bool plain_;
  std::set<std::string> refused_;
  std::string notes_;
};

// The parameters that experiments begin with: all candidates of the scene, dense, whole pixels.
lab::MatchParams block_match(const dataset::StereoScene& scene, lab::Cost cost, int block_width,
                             int block_height, bool derivative);
// A preset for the scene's candidates; none of that name: none.
std::optional<lab::MatchParams> preset(const dataset::StereoScene& scene, std::string_view name);

// The pixels that a filter or a check took from a map, right or wrong by the truth they have.
struct Removal {
  double removed = 0;  // share of the pixels that had a disparity
  std::optional<double> wrong_of_removed;
  std::optional<double> removed_of_wrong;
  std::optional<double> removed_of_right;
  std::optional<double> wrong_before;  // of the pixels with a disparity
  std::optional<double> wrong_after;
};
Removal removal(const dataset::Image<float>& before, const dataset::Image<float>& after,
                const dataset::Image<float>& truth);
// The same as a picture's findings.
dataset::Image<Finding> removed_pixels(const dataset::Image<float>& before,
                                       const dataset::Image<float>& after,
                                       const dataset::Image<float>& truth);

// Usual figures of a map.
Figure map_figure(const Subject& subject, const dataset::Image<float>& disparity, std::string title,
                  std::string caption);
Figure difference_figure(const Subject& subject, const dataset::Image<float>& disparity,
                         std::string title, std::string caption);  // of a scene with truth
Figure height_field_figure(const Subject& subject, const dataset::Image<float>& disparity,
                           std::string title, std::string caption, bool quick);

// "7.4 % bad not occluded, 17.2 % bad of all, 99.9 % dense, 1.2 ms": what is known of it.
std::string in_words(const Outcome& outcome);
// The headline of a score: not occluded where there is a mask, else all.
std::optional<double> headline(const DisparityScore& score);

}  // namespace stof::host

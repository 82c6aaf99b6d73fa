// The command line of the studies, see study.h.
#include <algorithm>
#include <memory>
#include <utility>

#include "app/command_parts.h"
#include "app/study.h"

namespace app {
namespace {

struct StudyArguments {
  Common common;
  std::string pattern;
  std::optional<std::string> renderer;
  int threads = 0;
};

int study_command(const StudyArguments& a, StudyOptions options, const std::vector<std::string>& arguments,
                  int (*study)(const StudyOptions&)) {
  options.layout = a.common.layout();
  options.names = selected(options.layout, a.pattern);
  options.renderer =
      renderer_of(options.layout, a.renderer, std::max(a.threads, 1));  // cases run side by side
  // As typed, but for where things are on this machine.
  options.command = "assay";
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--suite" || word == "--build" || word == "--write")
      ++i;
    else if (word.rfind("--suite=", 0) != 0 && word.rfind("--build=", 0) != 0 &&
             word.rfind("--write=", 0) != 0)
      options.command += " " + word;
  }
  return study(options);
}

}  // namespace

void add_study(CLI::App& app, const std::vector<std::string>& arguments, int& code) {
  CLI::App* study = app.add_subcommand("study", "Measure the judge's own error rates: docs/judge.md");
  study->require_subcommand(1);
  const auto add = [&](const char* name, const char* what, int (*run)(const StudyOptions&)) {
    // Filled in by the parser, after this function has returned.
    const auto a = std::make_shared<StudyArguments>();
    const auto o = std::make_shared<StudyOptions>();
    CLI::App* command = study->add_subcommand(name, what);
    add_common(command, a->common);
    command->add_option("-k", a->pattern, "Only cases whose name holds PATTERN")->type_name("PATTERN");
    command
        ->add_option("--write", o->write_file, "Put the tables into this page, between the study's markers")
        ->type_name("FILE.md");
    add_renderer(command, a->renderer, a->threads);
    command->callback([a, o, run, &arguments, &code] { code = study_command(*a, *o, arguments, run); });
    return std::pair(command, o.get());
  };
  const auto [null_app, null] =
      add("null", "How often a picture that differs by noise alone is called something", study_null);
  null_app->add_option("--trials", null->trials, "Goldens, renders and fresh seeds, of all cases together")
      ->check(between(1, 10000000))
      ->capture_default_str();
  null_app->add_option("--level", null->level, "False alarms a case may give")
      ->check(between(1e-8, .5))
      ->capture_default_str();
  null_app->add_option("--pixels", null->pixels, "Of a picture, about")
      ->check(between(64, 65536))
      ->capture_default_str();
  null_app->add_option("--spp", null->spp, "Samples of a pixel, in 8 replicates")
      ->check(between(8, 4096))
      ->capture_default_str();
  const auto [power_app, power] =
      add("power", "How often a bias of known size is found, at the cases' own samples", study_power);
  power_app->add_option("--seeds", power->seeds, "Trials of each case and bias")
      ->check(between(3, 1000))
      ->capture_default_str();
}

}  // namespace app

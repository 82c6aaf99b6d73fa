#include "app/commands.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "app/audit.h"
#include "app/calibrate.h"
#include "app/command_parts.h"
#include "app/compare.h"
#include "app/new_case.h"
#include "app/results.h"
#include "app/run.h"
#include "app/version.h"
#include "base/error.h"
#include "image/io.h"
#include "report/report.h"
#include "report/summaries.h"
#include "suite/schema.h"

namespace app {
namespace {

constexpr const char* description =
    R"(assay: judges the pictures of a renderer against stored goldens, Blender, POV-Ray and closed forms.

  assay run                        render every case, judge it, write build/results and the report
  assay run -k 'furnace*' -j 2     only some
  assay run --quick                only those whose first samples differ; seconds if nothing changed
  assay report                     write the page about the last run again: build/report/index.html
  assay review                     what is pending, with numbers
  assay accept cornell --because "Box moved by 1 cm, see #12"
  assay undo                       take the last accept back
  assay new-case box --scene regression/scenes/box.glb --why "Notices a lost bounce."
  assay report --junit junit.xml --markdown summary.md
  assay compare a.exr b.exr --flip-map map.exr
  assay calibrate --all            measure noise floors, write limits into the cases
  assay audit                      check what is stored, without rendering

Exit code: 0 fine; 1 a picture changed, differs from its witness or is bad; 2 could not run.)";

struct RunArguments {
  Common common;
  std::string pattern;
  std::optional<std::string> renderer;
  bool list = false, require_witnesses = false, quick = false, judge_only = false;
  int threads = 0;
};

int run_command(const RunArguments& a, const std::string& program) {
  RunOptions options;
  options.layout = a.common.layout();
  options.names = selected(options.layout, a.pattern);
  if (a.list) {
    for (const std::string& name : options.names) {
      std::cout << name << "\n    " << suite::read_case(options.layout, name).why << "\n";
    }
    return 0;
  }
  options.renderer = renderer_of(options.layout, a.renderer, a.threads);
  options.require_witnesses = a.require_witnesses;
  options.quick = a.quick;
  options.judge_only = a.judge_only;
  options.program = program;
  if (!a.common.suite.empty()) options.accept_options += " --suite " + a.common.suite;
  if (!a.common.build.empty()) options.accept_options += " --build " + a.common.build;
  // On a terminal one line of progress that the next line overwrites; in a file only the verdicts.
  const bool terminal = isatty(2) != 0;
  const auto clear = [terminal] {
    if (terminal) std::cerr << "\r\033[K" << std::flush;
  };
  options.on_case = [&](const CaseOutcome& c) {
    clear();
    std::cout << line_of(c) << std::endl;
    // What could not run is an error of this program's run, too, wherever its output goes.
    if (c.golden.verdict == suite::Verdict::error) complain(c.name + ": " + c.golden.reason);
    for (const WitnessOutcome& w : c.witnesses)
      if (w.result.verdict == suite::Verdict::error && w.result.reason != c.golden.reason)
        complain(c.name + ": " + w.entry.label + ": " + w.result.reason);
  };
  if (terminal)
    options.on_progress = [&](const std::string& line) { clear(), std::cerr << line << std::flush; };
  const RunResult result = run(options);
  clear();
  std::cout << summary_of(options, result) << std::flush;
  if (!result.cases.empty()) std::cout << "report: " << report::write(options.layout.build) << std::endl;
  return result.exit_code;
}

int accept_command(const Common& common, const std::vector<std::string>& names, const std::string& because) {
  const suite::Layout layout = common.layout();
  demand_cases(layout, names);
  std::vector<suite::Case> cases;
  for (const std::string& name : names) cases.push_back(suite::read_case(layout, name));
  golden::accept(layout, cases, because);
  for (const std::string& name : names) std::cout << "accepted " << layout.golden_file(name) << "\n";
  return 0;
}

int reject_command(const Common& common, const std::vector<std::string>& names) {
  const suite::Layout layout = common.layout();
  golden::reject(layout, names);
  for (const std::string& name : names) std::cout << "rejected " << name << ": the golden stays as it was\n";
  return 0;
}

int review_command(const Common& common) {
  const suite::Layout layout = common.layout();
  const std::vector<std::string> names = golden::pending_names(layout);
  if (names.empty()) std::cout << "nothing is pending\n";
  for (const std::string& name : names) {
    std::cout << name << "\n";
    try {
      const nlohmann::json result = suite::read_json(layout.result_file(name));
      std::cout << "    " << result.value("verdict", "") << ": " << result.value("reason", "") << "\n    ";
      for (const auto& m : result.at("golden").at("measures"))
        if (m.contains("limit"))
          std::cout << m.value("name", "") << " " << m.at("value") << " (limit " << m.at("limit") << ")  ";
      std::cout << "\n    new    " << layout.pending_file(name) << "\n    golden " << layout.golden_file(name)
                << "\n";
      if (const std::string why = golden::refusal(layout, suite::read_case(layout, name)); !why.empty())
        std::cout << "    cannot be accepted: " << why << "\n";
      else
        std::cout << "    " << result.value("accept", "") << "\n";
    } catch (const std::exception& error) {
      std::cout << "    cannot be accepted: " << error.what() << "\n";
    }
  }
  return 0;
}

struct ReportArguments {
  Common common;
  std::string file, junit, markdown;
  std::vector<std::string> shards;
  bool annotations = false;
};

// Standard output for "-": where a pipe is wanted.
void write_text(const std::string& file, const std::string& text) {
  if (file == "-")
    std::cout << text << std::flush;
  else if (!file.empty())
    image::write_file(file, text.data(), text.size());
}

int report_command(const ReportArguments& a) {
  const std::string build = a.common.build.empty() ? a.common.layout().build : a.common.build;
  if (!a.shards.empty()) report::merge(build, a.common.layout().root, a.shards);
  write_text(a.junit, report::junit(build));
  write_text(a.markdown, report::markdown(build));
  if (a.annotations) std::cout << report::annotations(build);
  const bool piped = a.junit == "-" || a.markdown == "-" || a.annotations;
  const std::string page = report::write(build, a.file);
  if (!piped) std::cout << page << "\n";
  return 0;
}

int undo_command(const Common& common) {
  for (const std::string& name : golden::undo(common.layout()))
    std::cout << name << ": the golden is what it was, the accepted picture is pending again\n";
  return 0;
}

int audit_command(const Common& common) {
  const suite::Layout layout = common.layout();
  const std::vector<std::string> names = suite::case_names(layout), faults = audit(layout, names);
  for (const std::string& fault : faults) std::cout << fault << "\n";
  std::cout << names.size() << " cases, " << faults.size() << " faults\n";
  return faults.empty() ? 0 : 1;
}

struct CalibrateArguments {
  Common common;
  std::vector<std::string> names;
  std::optional<std::string> renderer;
  bool all = false;
  int threads = 0;
};

int calibrate_command(const CalibrateArguments& a, CalibrateOptions options) {
  options.layout = a.common.layout();
  if (a.all && !a.names.empty())
    base::fail("calibrate: wanted names of cases or --all, found both (", a.names.front(), ")");
  options.names = a.all ? suite::case_names(options.layout) : a.names;
  if (options.names.empty()) base::fail_in("calibrate", "", "names of cases, or --all", "neither");
  demand_cases(options.layout, options.names);
  options.renderer = renderer_of(options.layout, a.renderer, a.threads);
  return calibrate(options);
}

// The words that may follow `assay`.
std::vector<std::string> command_words(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::App* command : app.get_subcommands({})) words.push_back(command->get_name());
  return words;
}

int dispatch(const std::vector<std::string>& arguments) {
  CLI::App app(description);
  app.name("assay");
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("assay ") + version, "Print version and commit");
  int code = 2;

  RunArguments run_arguments;
  CLI::App* run = app.add_subcommand("run", "Render and judge cases");
  add_common(run, run_arguments.common);
  run->add_option("-k", run_arguments.pattern,
                  "Only cases whose name holds PATTERN, or fits it if it has * or ?")
      ->type_name("PATTERN");
  run->add_flag("--list", run_arguments.list, "List the cases and why they are there");
  run->add_flag("--require-witnesses", run_arguments.require_witnesses, "A witness that is SKIPPED fails");
  run->add_flag("--judge-only", run_arguments.judge_only,
                "No pending pictures, and of what CHANGED no renders by lobe: the verdicts, sooner");
  run->add_flag("--quick", run_arguments.quick,
                "First only the first 16 samples: cases that have their golden's are not looked at further");
  add_renderer(run, run_arguments.renderer, run_arguments.threads);
  run->footer("Example: assay run -k basic_pl --renderer 'mytool {scene} -o {out} -s {spp} --seed {seed}'");
  run->callback([&] { code = run_command(run_arguments, arguments.front()); });

  CompareOptions compare_options;
  CLI::App* compare_app =
      app.add_subcommand("compare", "Compare two pictures: FLIP, RMSE, bias (EXR, HDR, PNG, JPEG)");
  compare_app->add_option("reference", compare_options.reference, "The picture that is right")->required();
  compare_app->add_option("test", compare_options.test, "The other one")->required();
  compare_app->add_flag("--json", compare_options.json, "Print JSON");
  compare_app->add_option("--flip-map", compare_options.flip_map, "Write FLIP's map")
      ->type_name("OUT.exr")
      ->check(exr_in_a_folder);
  compare_app->add_option("--ppd", compare_options.pixels_per_degree, "Pixels per degree; default 67.02")
      ->check(between(1, 1000));
  CLI::Option* hdr =
      compare_app->add_flag("--hdr", compare_options.hdr, "HDR-FLIP; default unless one is PNG or JPEG");
  compare_app->add_flag("--ldr", compare_options.ldr, "LDR-FLIP")->excludes(hdr);
  compare_app->add_option("--max-flip", compare_options.max_flip, "Exit 0 up to this FLIP mean")
      ->check(between(0, 1));
  compare_app->add_option("--max-rmse", compare_options.max_rmse, "Exit 0 up to this RMSE")
      ->check(between(0, 1e6));
  compare_app->footer(
      "Exit 0: the same pixels, or inside the limits given; 1: different or not finite; 2: could not "
      "compare. Example: assay compare a.exr b.exr --max-flip "
      "0.02");
  compare_app->callback([&] { code = compare(compare_options); });

  Common accept_common, reject_common, review_common, undo_common, new_common, audit_common;
  std::vector<std::string> accept_names, reject_names;
  std::string because;
  CLI::App* accept = app.add_subcommand("accept", "Make pending pictures the goldens of their cases");
  add_common(accept, accept_common);
  accept->add_option("case", accept_names, "Names of cases")->required();
  accept->add_option("--because", because, "The reason; stands in the golden and in goldens/LOG.md")
      ->required();
  accept->callback([&] { code = accept_command(accept_common, accept_names, because); });

  CLI::App* reject = app.add_subcommand("reject", "Delete pending pictures");
  add_common(reject, reject_common);
  reject->add_option("case", reject_names, "Names of cases")->required();
  reject->callback([&] { code = reject_command(reject_common, reject_names); });

  CLI::App* review = app.add_subcommand("review", "List pending pictures with their numbers");
  add_common(review, review_common);
  review->callback([&] { code = review_command(review_common); });

  CLI::App* undo = app.add_subcommand("undo", "Take the last accept back");
  add_common(undo, undo_common);
  undo->callback([&] { code = undo_command(undo_common); });

  NewCase new_options;
  CLI::App* new_app = app.add_subcommand("new-case", "Write the file of a new case");
  add_common(new_app, new_common);
  new_app->add_option("name", new_options.name, "Its name: a-z, 0-9, _")->required();
  new_app->add_option("--scene", new_options.scene, "A file in the suite's scenes/")
      ->required()
      ->type_name("FILE");
  new_app->add_option("--why", new_options.why, "One sentence: what this case alone would notice")
      ->required();
  new_app->add_option("--shader", new_options.shader, "Default disney");
  new_app->add_option("--width", new_options.width, "Default 64")->check(between(1, 4096));
  new_app->add_option("--height", new_options.height, "Default 64")->check(between(1, 4096));
  new_app
      ->add_option("--spp", new_options.spp, "Default 256; calibrate --set-spp chooses them by measurement")
      ->check(between(8, 1048576));
  new_app->add_option("--depth", new_options.depth, "Scattering events; default 4")
      ->check(between(0, 1000));
  new_app->callback([&] { new_case(new_common.layout(), new_options), code = 0; });

  ReportArguments report_arguments;
  CLI::App* report_app =
      app.add_subcommand("report", "Write the HTML report about the last run again, and summaries");
  add_common(report_app, report_arguments.common);
  report_app->add_option("-o,--out", report_arguments.file, "Default: report/index.html in the build folder")
      ->type_name("FILE");
  report_app->add_option("--junit", report_arguments.junit, "Also JUnit XML; - is standard output")
      ->type_name("FILE");
  report_app
      ->add_option("--markdown", report_arguments.markdown,
                   "Also a summary for a pull request; - is standard output")
      ->type_name("FILE");
  report_app->add_flag("--annotations", report_arguments.annotations,
                       "Also GitHub's ::error lines on standard output");
  report_app
      ->add_option("--merge", report_arguments.shards,
                   "First gather the results of these build folders (shards of a run) in the build folder")
      ->type_name("DIR");
  report_app->footer("Example: assay report --merge shard0 shard1 --build build --junit build/junit.xml");
  report_app->callback([&] { code = report_command(report_arguments); });

  CLI::App* audit_app = app.add_subcommand("audit", "Check goldens and stored witnesses without rendering");
  add_common(audit_app, audit_common);
  audit_app->callback([&] { code = audit_command(audit_common); });

  CalibrateArguments calibrate_arguments;
  CalibrateOptions calibrate_options;
  CLI::App* calibrate_app =
      app.add_subcommand("calibrate", "Measure noise floors, write limits (and samples) into cases");
  add_common(calibrate_app, calibrate_arguments.common);
  calibrate_app->add_option("case", calibrate_arguments.names, "Names of cases");
  calibrate_app->add_flag("--all", calibrate_arguments.all, "All cases");
  calibrate_app->add_option("--seeds", calibrate_options.seeds, "Independent renders to compare; default 4")
      ->check(between(2, 64));
  calibrate_app->add_option("--factor", calibrate_options.factor, "Limits are this many floors; default 2")
      ->check(between(1, 3));
  calibrate_app->add_flag("--set-spp", calibrate_options.set_spp,
                          "Also set spp so that the margins can be shown");
  calibrate_app->add_flag("--set-margins", calibrate_options.set_margins,
                          "Also set the margin of tiles to what the samples can show, at least 5 %");
  calibrate_app
      ->add_option("--budget", calibrate_options.budget_s,
                   "Seconds one render may take with --set-spp; default 3")
      ->check(between(.001, 3600));
  calibrate_app->add_flag("--dry-run", calibrate_options.dry_run, "Measure and print only");
  add_renderer(calibrate_app, calibrate_arguments.renderer, calibrate_arguments.threads);
  calibrate_app->callback([&] { code = calibrate_command(calibrate_arguments, calibrate_options); });

  add_study(app, arguments, code);
  add_speed(app, arguments, code);

  // A wrong first word deserves a better answer than a list of what is required.
  const std::vector<std::string> words = command_words(app);
  if (arguments.size() > 1 && arguments[1].rfind('-', 0) != 0 &&
      std::find(words.begin(), words.end(), arguments[1]) == words.end()) {
    const std::string near = suite::near_miss(arguments[1], words);
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
    base::fail_in("command", "", near.empty() ? "one of " + all : "a command (did you mean " + near + "?)",
                  "'" + arguments[1] + "'");
  }
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend() - 1);
  try {
    app.parse(reversed);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    base::fail(error.what(), " (assay --help, assay COMMAND --help)");
  }
  return code;
}

}  // namespace

int assay_main(const std::vector<std::string>& arguments) {
  try {
    return dispatch(arguments);
  } catch (const std::exception& error) {
    complain(error.what());
    return 2;
  }
}

}  // namespace app

// assay-render: renders a glTF scene to a file. See assay-render --help and docs/formats.md.
#include <string>
#include <vector>

#include "app/describe.h"
#include "app/job.h"
#include "base/error.h"

namespace {

using nlohmann::json;

void print_line(const nlohmann::ordered_json& object) {
  app::print_result(object.dump(-1, ' ', false, json::error_handler_t::replace) + "\n");
}

void print_info(app::Options& options, app::Stage& stage) {
  const scene::Scene& scene = stage.prepare(options);
  const auto description =
      app::describe(options, scene, integrator::Renderer(scene, options.render).summary());
  if (options["json"]) return print_line(description);
  app::print_result(app::describe_text(description));
}

int run(const app::Options& options, app::Console& console) {
  if (!options.answer.empty()) return app::print_result(options.answer), 0;
  if (!options["info"]) app::watch_signals();
  const bool batch = options.has("batch");
  for (const char* name : {"scene", "out", "info"})
    if (batch && options.has(name))
      base::fail("--batch: wanted no --", name, " beside it, found '", options.text(name), "'");

  // Without --batch there is one job, and it adds nothing to the command line.
  const json jobs = batch ? app::read_jobs(options.text("batch")) : json::array({json::object()});
  app::Stage stage;
  bool failed = false;
  for (size_t i = 0; i < jobs.size() && (i == 0 || app::stop_signal() == 0); ++i) {
    app::Options job = options;
    app::Result result;
    try {
      app::apply_job(job, jobs[i]);
      app::complete(job);
      console.open_log(job.text("log"));
      console.log(app::command(job, true));
      if (job["info"])
        print_info(job, stage);
      else
        result = app::run(job, stage, console);
    } catch (const std::exception& error) {
      failed = true;
      result.out = job.text("out");
      result.error = app::message(error);
      console.error((batch ? options.text("batch") + ": job " + std::to_string(i + 1) + ": " : "") +
                    result.error);
    }
    if (options["json"] && !options["info"]) print_line(json(result));
  }
  return failed ? 2 : app::stop_signal() != 0 ? 128 + app::stop_signal() : 0;
}

}  // namespace

int main(int argc, char** argv) {
  app::Console console;
  try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    const app::Options options =
        app::parse_command_line(words.empty() ? std::vector<std::string>{"--help"} : words);
    if (words.empty()) return std::fputs(options.answer.c_str(), stderr), 2;
    console = app::Console(options["quiet"]);
    return run(options, console);
  } catch (const std::exception& error) {
    console.error(app::message(error));
    return 2;
  }
}

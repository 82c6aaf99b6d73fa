// assay-render: renders a glTF scene to a file. See assay-render --help and docs/formats.md.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/batch.h"
#include "app/console.h"
#include "app/describe.h"
#include "app/job.h"
#include "app/options.h"
#include "app/version.h"

namespace {

int info(app::Options& options) {
  app::Stage stage;
  const scene::Scene& scene = stage.prepare(options);
  const integrator::Renderer renderer(scene, options.render);
  const nlohmann::json description = app::describe(options, scene, renderer.summary());
  if (options.json)
    app::print_json(description);
  else
    std::fputs(app::describe_text(description).c_str(), stdout);
  return 0;
}

int render(app::Options& options) {
  app::Result result;
  try {
    app::complete(options);
    app::Console console(options.quiet, options.log);
    console.log(app::command(options, true));
    app::Stage stage;
    result = app::run(options, stage, console);
  } catch (const std::exception& error) {
    result.out = options.out;
    result.error = app::message(error);
    if (options.json) app::print_json(app::to_json(result));
    throw;
  }
  if (options.json) app::print_json(app::to_json(result));
  return result.partial ? 128 + app::stop_signal() : 0;
}

int run(int argc, char** argv) {
  if (argc == 1) {
    std::fputs(app::help().c_str(), stderr);
    return 2;
  }
  app::Options options = app::parse_command_line(std::vector<std::string>(argv + 1, argv + argc));
  if (options.help) return std::fputs(app::help().c_str(), stdout), 0;
  if (options.version)
    return std::printf("assay-render %s (commit %s)\n", app::version().c_str(), app::commit().c_str()), 0;
  if (options.info && options.batch.empty()) return app::complete(options), info(options);
  app::watch_signals();
  return options.batch.empty() ? render(options) : app::run_batch(options);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    app::Console(true, "").error(app::message(error));
    return 2;
  }
}

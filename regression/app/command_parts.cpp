#include "app/command_parts.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "base/error.h"
#include "suite/schema.h"

namespace app {

void add_common(CLI::App* command, Common& common) {
  command
      ->add_option("--suite", common.suite,
                   "Folder with cases/, scenes/, goldens/; default: regression/, found upwards")
      ->type_name("DIR");
  command
      ->add_option("--build", common.build, "Folder for everything written; default: build/ beside the suite")
      ->type_name("DIR");
}

void demand_cases(const suite::Layout& layout, const std::vector<std::string>& names) {
  const std::vector<std::string> known = suite::case_names(layout);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string near = suite::near_miss(name, known);
    base::fail_in(layout.root + "/cases", "",
                  near.empty() ? "a case (assay run --list)" : "a case (did you mean " + near + "?)", name);
  }
}

CLI::Validator between(double low, double high) {
  std::ostringstream range;  // as CLI11 describes its own ranges in --help
  range.precision(10);
  range << "in [" << low << " - " << high << "]";
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double value = 0;
        const bool is_number = CLI::detail::lexical_cast(text, value);
        if (is_number && value >= low && value <= high) return {};
        std::ostringstream message;
        message.precision(10);
        message << "wanted a number from " << low << " to " << high << ", found " << text;
        return message.str();
      },
      range.str());
}

const CLI::Validator exr_in_a_folder(
    [](std::string& text) -> std::string {
      const std::filesystem::path path(text);
      if (path.extension() != ".exr") return text + ": wanted a file that ends in .exr";
      if (path.has_parent_path() && !std::filesystem::is_directory(path.parent_path()))
        return text + ": wanted a folder that exists";
      return {};
    },
    "");

suite::RendererCommand renderer_of(const suite::Layout& layout, const std::optional<std::string>& given,
                                   int threads) {
  const std::string command = given.value_or("");
  if (given && command.empty()) base::fail("--renderer: wanted a command, found nothing");
  suite::RendererCommand renderer = command.empty() ? suite::RendererCommand::ours(layout.build)
                                                    : suite::RendererCommand::from_template(command);
  renderer.set_threads(threads);
  return renderer;
}

void complain(const std::string& message) {
  std::cerr << (message.rfind("assay: ", 0) == 0 ? "" : "assay: ") << message << std::endl;
}

std::vector<std::string> selected(const suite::Layout& layout, const std::string& pattern) {
  std::vector<std::string> names;
  for (const std::string& name : suite::case_names(layout))
    if (pattern.empty() || suite::matches(pattern, name)) names.push_back(name);
  if (names.empty())
    base::fail_in("-k", "", "a pattern that some case has (assay run --list)", "'" + pattern + "'");
  return names;
}

void add_renderer(CLI::App* command, std::optional<std::string>& renderer, int& threads) {
  command
      ->add_option("--renderer", renderer,
                   "Another renderer, started once per picture without a shell: 'CMD {scene} {out} {width} "
                   "{height} {spp} "
                   "{seed} {shader} {depth} {camera} {replicates} {threads}'; default: assay-render beside "
                   "this program")
      ->type_name("'CMD …'");
  command->add_option("-j,--threads", threads, "Threads of the renderer; default: all")
      ->check(between(1, 1024));
}

}  // namespace app

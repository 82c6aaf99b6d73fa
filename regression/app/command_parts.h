// What the commands of `assay` have in common: options, checks of their values, the renderer.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "suite/case_file.h"
#include "suite/renderer_command.h"

namespace app {

struct Common {
  std::string suite, build;
  suite::Layout layout() const { return suite::Layout::find(suite, build); }
};

void add_common(CLI::App* command, Common& common);
void add_renderer(CLI::App* command, std::optional<std::string>& renderer, int& threads);

// Checks that names are cases, so that a typing error is not an empty run.
void demand_cases(const suite::Layout& layout, const std::vector<std::string>& names);

// The cases that a pattern selects; base::Error if there are none.
std::vector<std::string> selected(const suite::Layout& layout, const std::string& pattern);

// A number from low to high; CLI11's own ranges let NaN through.
CLI::Validator between(double low, double high);

// Where a user's own picture may go.
extern const CLI::Validator exr_in_a_folder;

suite::RendererCommand renderer_of(const suite::Layout& layout, const std::optional<std::string>& given,
                                   int threads);

// Prints an error. Each begins with the program's name, whoever found it.
void complain(const std::string& message);

// Adds `assay study null` and `assay study power`. `arguments` are the program's, `code` what it will end
// with; both must outlive the parsing.
void add_study(CLI::App& app, const std::vector<std::string>& arguments, int& code);

// Adds `assay speed`; the same holds.
void add_speed(CLI::App& app, const std::vector<std::string>& arguments, int& code);

}  // namespace app

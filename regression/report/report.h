// The report: one self-contained HTML file about a run, made from its stored JSON and pictures alone. It
// needs no network and no other file; without JavaScript it still shows everything but the exposure slider,
// the viewer and the filters. The same results give the same bytes.
#pragma once

#include <cstddef>
#include <string>

namespace report {

// Float pictures for the viewer are left out, passing cases first, where the page would grow beyond this.
inline constexpr std::size_t most_bytes = 14'000'000;

// The page about what lies in a build folder: run.json, results/, and the pictures those name. Throws
// base::Error only if there are no results.
std::string page(const std::string& build);

// Writes the page; `file` empty: build/report/index.html. Returns the path.
std::string write(const std::string& build, const std::string& file = "");

}  // namespace report

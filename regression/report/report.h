// The report: one self-contained HTML file about a run, made from its stored JSON and pictures alone. It
// needs no network and no other file. Pictures are half floats that the page draws, so that exposure and the
// pixel inspector work on what was rendered. The same results give the same bytes.
#pragma once

#include <cstddef>
#include <string>

namespace report {

// Where the page would grow beyond this, pictures become PNGs: first those of IDENTICAL cases without another
// renderer's picture, then those of the last cases.
inline constexpr std::size_t most_bytes = 15'000'000;

// The page about what lies in a build folder: run.json, results/, and the pictures those name. Throws
// base::Error only if there are no results.
std::string page(const std::string& build, std::size_t most = most_bytes);

// Writes the page; `file` empty: build/report/index.html. Returns the path.
std::string write(const std::string& build, const std::string& file = "");

}  // namespace report

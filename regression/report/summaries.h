// The run for machines and pull requests, from the same stored results as the page: JUnit XML, Markdown, and
// lines that GitHub shows beside the files they name.
#pragma once

#include <string>
#include <vector>

namespace report {

// JUnit XML: a test per case and per witness of a case. CHANGED, NOISIER, UNDECIDED, BROKEN and DIFFERS are
// failures, ERROR is an error, SKIPPED is skipped. Each throws base::Error if the folder holds no results.
std::string junit(const std::string& build);

// A few lines and one table of the cases that did not pass, with the command that accepts each.
std::string markdown(const std::string& build);

// "::error file=...,title=...::..." for each case or witness that did not pass; paths relative to the working
// tree.
std::string annotations(const std::string& build);

// Gathers the results of shards (build folders, perhaps fetched from other machines) in `build`: results,
// pictures, pending pictures and one run.json. Paths into the suite are made to point to the suite in
// `suite_root`. Throws base::Error for a folder without results or a case that two shards judged; nothing is
// then written.
void merge(const std::string& build, const std::string& suite_root, const std::vector<std::string>& shards);

}  // namespace report

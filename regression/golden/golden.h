// Goldens: what the pictures looked like when somebody last said that they were right. See docs/formats.md,
// "Golden".
//
// A new or changed case leaves a pending picture in the build folder, which is a golden but for the reason.
// Accepting it adds the reason and moves it in place, atomically; nothing else ever writes a golden, and
// nothing does where the environment variable CI is set.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "suite/case_file.h"
#include "suite/judge.h"

namespace golden {

// Throws base::Error if the file is no golden: no provenance, no exposures, no variance.
suite::Golden read(const std::string& file);

// Writes a render as the pending picture of its case: case hash, pixel hash, exposures and replicate tiles
// added, all other layers dropped. A golden's exposures are kept, so that the metric does not move with the
// picture.
void write_pending(const suite::Layout& layout, const suite::Case& c, const suite::Hashes& hashes,
                   const image::Render& render, const std::optional<suite::Golden>& previous);

// Adds the hash of the case's first samples (app/quick.h) and the means of its lobes to its pending picture.
void sign(const suite::Layout& layout, const suite::Case& c, const std::string& quick_hash,
          const std::vector<suite::LobeMean>& lobes);

// Why a pending picture may not become a golden; empty: it may. Missing, made for an older case, non-finite,
// ...
std::string refusal(const suite::Layout& layout, const suite::Case& c);

// Makes pending pictures goldens, all or none of them being refused, and adds a paragraph to goldens/LOG.md.
// Throws base::Error where CI is set, `because` says nothing, or one of them may not.
void accept(const suite::Layout& layout, const std::vector<suite::Case>& cases, const std::string& because);

// Takes the last accept of this build folder back: the goldens and the log are what they were, the pictures
// are pending again. Returns the names. Throws base::Error where CI is set, there was none, or one of them
// changed since.
std::vector<std::string> undo(const suite::Layout& layout);

// Deletes pending pictures. Throws base::Error for a case that has none.
void reject(const suite::Layout& layout, const std::vector<std::string>& names);

// The names that have a pending picture, sorted.
std::vector<std::string> pending_names(const suite::Layout& layout);

// Goldens and witness pictures that belong to no case (or to no witness of one): one line each.
std::vector<std::string> orphans(const suite::Layout& layout);

}  // namespace golden

#include "app/audit.h"

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "golden/golden.h"
#include "image/io.h"
#include "suite/witness_judge.h"

namespace app {
namespace {

namespace fs = std::filesystem;

// Provenance every golden carries. A foreign renderer need not tell its version and commit.
constexpr const char* demanded[] = {"assay:because",      "assay:accepted",   "assay:case_hash",
                                    "assay:picture_hash", "assay:scene_hash", "assay:pixel_hash"};

void audit_golden(const suite::Layout& layout, const suite::Case& c, const suite::Hashes& hashes,
                  std::vector<std::string>& faults) {
  const std::string file = layout.golden_file(c.name);
  if (!fs::exists(file)) return faults.push_back(c.name + ": golden missing: " + file);
  const suite::Golden golden = golden::read(file);
  if (const std::string fault = suite::golden_fault(c, hashes, golden); !fault.empty())
    faults.push_back(file + ": " + fault);
  const std::vector<float>& pixels = golden.render.mean.data;
  if (std::any_of(pixels.begin(), pixels.end(), [](float v) { return v < 0; }) && c.shader != "normal" &&
      c.shader != "position")
    faults.push_back(file + ": pixels: wanted radiance of 0 or more, found a negative one");
  for (const char* key : demanded)
    if (image::header_string(golden.render.header, key).value_or("").empty())
      faults.push_back(file + ": " + key + ": wanted a text in the header, found none");
}

void audit_witness(const suite::Layout& layout, const suite::Case& c, const suite::Hashes& hashes,
                   const suite::Witness& w, std::vector<std::string>& faults) {
  if (w.kind == suite::WitnessKind::analytic) return;
  const std::string file = layout.witness_file(c, w);
  if (!fs::exists(file))
    return faults.push_back(c.name + ": " + w.label + ": stored picture missing: " + file);
  const std::string fault = suite::witness_fault(
      c, w, hashes, suite::script_hash(layout.witness_folder(w.kind)), image::read_render(file));
  if (!fault.empty()) faults.push_back(file + ": " + fault);
}

}  // namespace

std::vector<std::string> audit(const suite::Layout& layout, const std::vector<std::string>& names) {
  std::vector<std::string> faults;
  // Each step has its own net: one bad file must not hide the next.
  const auto guarded = [&](const auto& step) {
    try {
      step();
    } catch (const base::Error& error) {
      faults.push_back(error.what());
    }
  };
  for (const std::string& name : names)
    guarded([&] {
      const suite::Case c = suite::read_case(layout, name);
      const suite::Hashes hashes = suite::hashes_of(layout, c);
      if (!c.limits) faults.push_back(c.file + ": limits: wanted those of assay calibrate, found none");
      guarded([&] { audit_golden(layout, c, hashes, faults); });
      for (const suite::Witness& w : c.witnesses)
        guarded([&] { audit_witness(layout, c, hashes, w, faults); });
    });
  for (const std::string& orphan : golden::orphans(layout)) faults.push_back(orphan);
  return faults;
}

}  // namespace app

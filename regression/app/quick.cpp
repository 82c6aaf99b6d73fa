#include "app/quick.h"

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "image/hash.h"
#include "image/io.h"

namespace app {

suite::Job quick_job(const suite::Layout& layout, const suite::Case& c) {
  suite::Job job = job_of(layout, c);
  job.spp = std::min(quick_samples, c.spp / c.replicates);
  job.replicates = 1;
  job.layers.clear();
  job.out = std::filesystem::absolute(layout.render_file(c.name + ".quick")).string();
  return job;
}

std::map<std::string, std::string> quick_hashes(const RunOptions& options,
                                                const std::vector<suite::Case>& cases) {
  std::vector<suite::Job> jobs;
  for (const suite::Case& c : cases) jobs.push_back(quick_job(options.layout, c));
  std::map<std::string, std::string> hashes;
  options.renderer.run(
      jobs, options.layout.build + "/renders", [&](std::size_t j, const suite::Outcome& rendered) {
        if (options.on_progress)
          options.on_progress("first samples " + std::to_string(j + 1) + " of " +
                              std::to_string(jobs.size()) + ": " + cases[j].name);
        if (!rendered.ok) return;
        try {
          const image::Render picture = image::read_render(jobs[j].out);
          const bool rejected = image::header_int(picture.header, "assay:rejected").value_or(0) != 0;
          if (!rejected && image::count_non_finite(picture.mean) == 0)
            hashes[cases[j].name] = image::pixel_hash(picture.mean);
        } catch (const base::Error&) {
          // A picture that cannot be read has no hash; the full judgement will say why.
        }
        std::filesystem::remove(jobs[j].out);
      });
  return hashes;
}

std::vector<std::string> quickly_identical(const RunOptions& options) {
  std::vector<suite::Case> cases;
  std::map<std::string, std::string> wanted;
  for (const std::string& name : options.names) {
    try {
      suite::Case c = suite::read_case(options.layout, name);
      const suite::Golden golden = golden::read(options.layout.golden_file(name));
      if (!c.limits || golden.quick_hash.empty() ||
          !suite::golden_fault(c, suite::hashes_of(options.layout, c), golden).empty())
        continue;
      wanted[name] = golden.quick_hash;
      cases.push_back(std::move(c));
    } catch (const base::Error&) {
      // Whatever is wrong with it is for the full judgement to say.
    }
  }
  std::vector<std::string> identical;
  for (const auto& [name, hash] : quick_hashes(options, cases))
    if (hash == wanted[name]) identical.push_back(name);
  return identical;
}

}  // namespace app

#include "app/lobes.h"

#include <filesystem>

#include "base/error.h"
#include "image/io.h"

namespace app {

std::map<std::string, std::vector<suite::LobeMean>> lobes_of(const RunOptions& options,
                                                             const std::vector<suite::Case>& cases) {
  std::map<std::string, std::vector<suite::LobeMean>> lobes;
  if (options.renderer.is_template()) return lobes;
  std::vector<suite::Job> jobs;
  for (const suite::Case& c : cases) {
    jobs.push_back(job_of(options.layout, c));
    jobs.back().layers = "lobes";
    jobs.back().out = std::filesystem::absolute(options.layout.render_file(c.name + ".lobes")).string();
  }
  options.renderer.run(jobs, options.layout.build + "/renders",
                       [&](std::size_t j, const suite::Outcome& rendered) {
                         if (options.on_progress)
                           options.on_progress("by lobe " + std::to_string(j + 1) + " of " +
                                               std::to_string(jobs.size()) + ": " + cases[j].name);
                         if (!rendered.ok) return;  // a shader of data, normals for one, has none
                         try {
                           lobes[cases[j].name] = suite::lobe_means(image::read_render(jobs[j].out));
                         } catch (const base::Error&) {
                           // They only explain; what is wrong with the picture itself is said elsewhere.
                         }
                         std::filesystem::remove(jobs[j].out);
                       });
  return lobes;
}

}  // namespace app

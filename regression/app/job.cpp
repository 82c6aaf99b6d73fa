// What a case asks of a renderer, and what came of it; declared in run.h.
#include <filesystem>

#include "app/run.h"
#include "base/error.h"
#include "image/io.h"

namespace app {

namespace fs = std::filesystem;

suite::Job job_of(const suite::Layout& layout, const suite::Case& c) {
  suite::Job job;
  job.scene = fs::absolute(layout.scene_file(c)).string();
  job.out = fs::absolute(layout.render_file(c.name)).string();
  job.shader = c.shader;
  job.width = c.width;
  job.height = c.height;
  job.spp = c.spp;
  job.replicates = c.replicates;
  job.depth = c.depth;
  job.camera = c.camera;
  job.seed = c.seed;
  job.options = c.options;
  job.layers = "replicates";
  job.timeout_s = c.timeout_s;
  return job;
}

image::Render read_job(const suite::RendererCommand& renderer, const suite::Job& job,
                       const std::string& scratch) {
  image::Render render = image::read_render(job.out);
  if (render.variance || !renderer.is_template()) return render;

  std::vector<suite::Job> jobs;
  for (int r = 0; r < job.replicates; ++r) {
    jobs.push_back(job);
    jobs.back().spp = job.spp / job.replicates;
    jobs.back().seed = job.seed + static_cast<std::uint32_t>(r) * 7919u;  // apart from any fresh_seed()
    jobs.back().out = job.out.substr(0, job.out.size() - 4) + ".replicate" + std::to_string(r) + ".exr";
  }
  const std::vector<suite::Outcome> outcomes = renderer.run(jobs, scratch);
  std::vector<image::Image> replicates;
  for (std::size_t r = 0; r < jobs.size(); ++r) {
    if (!outcomes[r].ok) base::fail(outcomes[r].error);
    replicates.push_back(image::read_render(jobs[r].out).mean);
    if (!replicates.back().same_shape(render.mean))
      base::fail_in(jobs[r].out, "size", "that of the first", "another");
    render.layers["replicate" + std::to_string(r)] = replicates.back();
  }
  const double count = static_cast<double>(replicates.size());
  render.variance = render.mean;
  for (std::size_t i = 0; i < render.mean.data.size(); ++i) {
    double sum = 0, squares = 0;
    for (const image::Image& r : replicates) sum += r.data[i];
    for (const image::Image& r : replicates) squares += (r.data[i] - sum / count) * (r.data[i] - sum / count);
    render.mean.data[i] = static_cast<float>(sum / count);
    render.variance->data[i] = static_cast<float>(squares / (count - 1) / count);
  }
  render.header["assay:replicates"] = job.replicates;
  render.header["assay:spp"] = job.spp;
  render.header["assay:command"] = renderer.text();
  image::write_exr(job.out, render);
  return render;
}

}  // namespace app

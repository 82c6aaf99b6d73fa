#include "suite/renderer_command.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "suite/testing.h"

namespace suite {
namespace {

// A batch renderer in Python whose scenes say what it shall do.
constexpr const char* batch_renderer = R"(#!/usr/bin/python3
import json, os, sys, time
log = open(os.path.join(os.path.dirname(sys.argv[0]), "log"), "a")
print("starting up")
for job in json.load(open(sys.argv[2]))["jobs"]:
    what = os.path.basename(job["scene"])
    print(what, job.get("layers"), job.get("threads"), job.get("d-gamma"), job["spp"], file=log, flush=True)
    report = {"out": job["out"], "ok": True, "seconds": 1.5}
    if what == "crash": os.kill(os.getpid(), 11)
    if what == "hang": time.sleep(60)
    if what == "exit": print("out of memory", file=sys.stderr); sys.exit(3)
    if what == "fail": report = {"out": job["out"], "ok": False, "error": "scene.glb: no\ncamera"}
    if what == "silent": continue
    if what == "good": open(job["out"], "w").write("x")
    print(json.dumps(report), flush=True)
)";

class Renderer : public ::testing::Test {
 protected:
  Job job(const std::string& scene, const std::string& out) {
    Job j;
    j.scene = scene;
    j.out = folder_.path() + "/out/" + out;
    j.shader = "path";
    j.width = j.height = 4;
    j.spp = 16;
    j.replicates = 8;
    j.timeout_s = scene == "hang" ? 1 : 30;
    return j;
  }
  std::vector<Outcome> batch(const std::vector<Job>& jobs) {
    testing::write_script(folder_.path() + "/bin/assay-render", batch_renderer);
    RendererCommand renderer = RendererCommand::ours(folder_.path());
    renderer.set_threads(3);
    return renderer.run(jobs, folder_.path());
  }
  std::string log() { return testing::read_text(folder_.path() + "/bin/log"); }
  testing::TemporaryFolder folder_;
};

TEST_F(Renderer, takes_all_jobs_in_one_process) {
  Job with_options = job("good", "b.exr");
  with_options.options = {{"d-gamma", 1.5}};
  with_options.layers = "replicates";
  const auto outcomes = batch({job("good", "a.exr"), with_options});
  ASSERT_EQ(outcomes.size(), 2u);
  EXPECT_TRUE(outcomes[0].ok && outcomes[1].ok);
  EXPECT_EQ(outcomes[0].seconds, 1.5);
  EXPECT_EQ(log(), "good None 3 None 16\ngood replicates 3 1.5 16\n");
}

TEST_F(Renderer, loses_only_the_job_that_crashes) {
  const auto outcomes = batch({job("good", "a.exr"), job("crash", "b.exr"), job("good", "c.exr")});
  EXPECT_TRUE(outcomes[0].ok);
  EXPECT_EQ(outcomes[1].error, "renderer crashed with signal 11 (Segmentation fault)");
  EXPECT_TRUE(outcomes[2].ok);
  EXPECT_EQ(log(),
            "good None 3 None 16\ncrash None 3 None 16\ngood None 3 None 16\n");  // nothing tried twice
}

TEST_F(Renderer, loses_only_the_job_that_hangs) {
  const auto outcomes = batch({job("hang", "a.exr"), job("good", "b.exr")});
  EXPECT_EQ(outcomes[0].error.substr(0, 27), "renderer timed out after 1 ");
  EXPECT_TRUE(outcomes[1].ok);
}

TEST_F(Renderer, passes_on_in_one_line_what_the_renderer_says) {
  const auto outcomes =
      batch({job("fail", "a.exr"), job("exit", "b.exr"), job("good", "c.exr"), job("silent", "d.exr")});
  EXPECT_EQ(outcomes[0].error, "renderer: scene.glb: no camera");
  EXPECT_EQ(outcomes[1].error, "renderer ended with exit code 3: out of memory");
  EXPECT_TRUE(outcomes[2].ok);
  EXPECT_EQ(outcomes[3].error, "renderer ended without a word about this job");
}

TEST_F(Renderer, does_not_believe_in_a_picture_that_is_not_there) {
  testing::write_text(folder_.path() + "/out/a.exr", "of yesterday");
  const auto outcomes = batch({job("claims", "a.exr")});
  EXPECT_FALSE(outcomes[0].ok);
  EXPECT_NE(outcomes[0].error.find("wrote no "), std::string::npos);
}

TEST_F(Renderer, gives_up_on_one_that_never_finishes_anything) {
  std::vector<Job> jobs;
  for (int i = 0; i < 10; ++i) jobs.push_back(job("crash", std::to_string(i) + ".exr"));
  const auto outcomes = batch(jobs);
  for (const Outcome& outcome : outcomes) EXPECT_FALSE(outcome.ok);
  EXPECT_EQ(outcomes[9].error,
            "renderer crashed with signal 11 (Segmentation fault) (not tried again: it finished no job)");
  EXPECT_EQ(log(), "crash None 3 None 16\ncrash None 3 None 16\ncrash None 3 None 16\n");
}

TEST_F(Renderer, must_exist) {
  EXPECT_THROW(RendererCommand::ours(folder_.path()), base::Error);
  const RendererCommand renderer = RendererCommand::from_template("/nonexistent {scene} {out}");
  EXPECT_EQ(renderer.run({job("good", "a.exr")}, folder_.path())[0].error,
            "renderer cannot start /nonexistent: No such file or directory");
}

TEST_F(Renderer, can_be_a_template_without_a_shell) {
  testing::write_script(folder_.path() + "/r.sh", "#!/bin/sh\nfor a; do echo \"$a\"; done > \"$2\"\n");
  const RendererCommand renderer =
      RendererCommand::from_template(folder_.path() +
                                     "/r.sh {scene} {out} '{width}x{height}' --s={spp},{seed} {shader} "
                                     "{depth} '$(touch /tmp/x) ; {camera}'");
  Job j = job("my scene.glb", "a b.exr");
  j.seed = 4000000000u, j.depth = 5;
  ASSERT_TRUE(renderer.run({j}, folder_.path())[0].ok);
  EXPECT_EQ(testing::read_text(j.out),
            "my scene.glb\n" + j.out + "\n4x4\n--s=16,4000000000\npath\n5\n$(touch /tmp/x) ; 0\n");
}

TEST_F(Renderer, as_a_template_must_be_sound) {
  EXPECT_THROW(RendererCommand::from_template("r {scene}"), base::Error);
  EXPECT_THROW(RendererCommand::from_template("r {out}"), base::Error);
  EXPECT_THROW(RendererCommand::from_template("r {scene} {out} {sppp}"), base::Error);
  EXPECT_TRUE(RendererCommand::from_template("r {scene} {out} {depth}").understands("depth"));
  EXPECT_FALSE(RendererCommand::from_template("r {scene} {out} {depth}").understands("shader"));
}

TEST_F(Renderer, as_a_template_may_crash_hang_and_lie) {
  testing::write_script(
      folder_.path() + "/r.sh",
      "#!/bin/sh\ncase $1 in crash) kill -ABRT $$;; hang) sleep 60;; exit) echo no >&2; exit 4;; esac\n");
  const RendererCommand renderer = RendererCommand::from_template(folder_.path() + "/r.sh {scene} {out}");
  const auto outcomes =
      renderer.run({job("crash", "a.exr"), job("hang", "b.exr"), job("exit", "c.exr"), job("lie", "d.exr")},
                   folder_.path());
  EXPECT_EQ(outcomes[0].error, "renderer crashed with signal 6 (Aborted)");
  EXPECT_EQ(outcomes[1].error.substr(0, 25), "renderer timed out after ");
  EXPECT_EQ(outcomes[2].error, "renderer ended with exit code 4: no");
  EXPECT_NE(outcomes[3].error.find("wrote no "), std::string::npos);
}

}  // namespace
}  // namespace suite

#include "app/new_case.h"

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "image/io.h"

namespace app {

namespace fs = std::filesystem;

void new_case(const suite::Layout& layout, const NewCase& o) {
  const std::string file = layout.case_file(o.name);
  if (o.name.empty() ||
      o.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos)
    base::fail_in("new-case", "", "a name of a-z, 0-9 and _", "'" + o.name + "'");
  if (fs::exists(file)) base::fail_in(file, "", "no such case yet", "one");
  const fs::path scenes = fs::absolute(layout.root + "/scenes").lexically_normal();
  const fs::path given = fs::exists(o.scene) ? fs::absolute(o.scene).lexically_normal() : scenes / o.scene;
  const std::string scene = given.lexically_relative(scenes).string();
  if (scene.empty() || scene.starts_with("..") || !fs::is_regular_file(given))
    base::fail_in("--scene", "", "a file in " + scenes.string(), o.scene);

  // In the order in which people read it.
  nlohmann::ordered_json json = {{"name", o.name},
                                 {"why", o.why},
                                 {"scene", scene},
                                 {"shader", o.shader},
                                 {"size", {o.width, o.height}},
                                 {"spp", o.spp},
                                 {"replicates", 8},
                                 {"seed", 1},
                                 {"depth", o.depth}};
  const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  image::write_file(file, text.data(), text.size());
  try {
    suite::read_case(layout, o.name);
  } catch (const base::Error&) {
    fs::remove(file);
    throw;
  }
  std::cout << "wrote " << file << "\nnext:\n  assay calibrate " << o.name
            << " --set-spp      # samples and limits from measured noise\n  assay run -k " << o.name
            << "                # renders it; BROKEN, as it has no golden\n  assay review\n  assay accept "
            << o.name << " --because \"…\"\n";
}

}  // namespace app

// Pictures on disk: by extension, whole or not at all (written beside the target, then renamed).
#pragma once

#include <span>

#include "app/options.h"
#include "image/film.h"
#include "integrator/render.h"
#include "scene/scene.h"

namespace app {

// Throws base::Error if --out could not be written, before an hour of rendering finds out, or is a file that
// is read.
void check_writable(const Options& options);

// `samples` per pixel are in every pixel of the films; `partial`: more were asked for. `parts`: of --layers
// lobes.
void write_picture(const Options& options, const scene::Scene& scene, const integrator::Renderer& renderer,
                   const image::Film& film, std::span<const image::Film> parts, int samples, bool partial);

// The map of --environment; fills options.environment_hash.
scene::Environment read_environment(Options& options);

}  // namespace app

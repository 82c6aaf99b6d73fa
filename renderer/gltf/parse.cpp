// tinygltf's window on the world: it sees a document without file names, and of the file system only the
// bytes the guard has read, under the names the guard gave them.
#include "base/error.h"
#include "gltf/reader.h"

namespace gltf {

tinygltf::Model parse(Document& document) {
  tinygltf::TinyGLTF loader;
  tinygltf::FsCallbacks files;
  files.FileExists = [](const std::string& name, void* data) {
    return static_cast<Document*>(data)->files.count(name) != 0;
  };
  files.ExpandFilePath = [](const std::string& name, void*) { return name; };
  files.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string& name,
                           void* data) {
    auto& all = static_cast<Document*>(data)->files;
    const auto found = all.find(name);
    if (found == all.end()) return false;
    *out = std::move(found->second);
    return true;
  };
  files.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  files.user_data = &document;
  loader.SetFsCallbacks(files);
  // Keep an image's bytes; image::decode reads those that are used.
  const auto keep = [](tinygltf::Image* image, int, std::string*, std::string*, int, int,
                       const unsigned char* bytes, int size, void*) {
    image->image.assign(bytes, bytes + size);
    return true;
  };
  loader.SetImageLoader(keep, nullptr);

  tinygltf::Model model;
  std::string error, warning;
  bool done = false;
  const std::string text = document.json.dump();
  try {
    done = loader.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                      static_cast<unsigned>(text.size()), "");
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  if (!done) base::fail(document.file, ": not glTF 2.0: ", error.substr(0, 200));
  return model;
}

}  // namespace gltf
